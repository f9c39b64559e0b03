//! What the figures say to do, in words.

use super::content::{Advice, Content, DepthRow};
use super::text::capitalised;
use super::words;

/// An error of penetration that contact proxies may have, over the diagonal.
const PROXY_ERROR: f64 = 0.01;

/// Savings below this are noise.
const WORTH: f64 = 0.1;

/// Advice from all parts but the modes', whose own says more.
pub(super) fn advice(content: &Content) -> Vec<Advice> {
    let mut all = Vec::new();
    let mut say = |topic: &str, text: Option<String>| {
        all.extend(text.map(|text| Advice {
            topic: topic.to_string(),
            text,
        }));
    };
    say("depth", depth(content));
    if let Some(refit) = &content.refit {
        for curve in &refit.curves {
            say("refit", words::sentence(curve));
        }
    }
    say("sections", sections(content));
    all
}

/// The first level that is near enough and faster than no limit.
fn depth(content: &Content) -> Option<String> {
    let last = content.depth.last()?;
    let pays = |r: &&DepthRow| r.time_rel <= 1.0 - WORTH;
    let near = |r: &&DepthRow| r.penetration_error_rel <= PROXY_ERROR;
    if let Some(first) = content.depth.iter().filter(pays).find(near) {
        return Some(format!(
            "With a level limit of {} (the deepest is {}) penetration depths are off by at most {} of the diagonal, \
             and a ball query takes {} less time than without a limit.",
            first.level,
            last.level,
            percent(first.penetration_error_rel),
            percent(1.0 - first.time_rel)
        ));
    }
    let Some(fastest) = content.depth.iter().rfind(pays) else {
        return Some(format!(
            "Use no level limit: none saves {} of the time of a ball query.",
            percent(WORTH)
        ));
    };
    Some(format!(
        "If you need exact penetration depths, use no level limit. Level {}, the deepest that saves at least {} of \
         the time, has depth errors up to {} of the diagonal.",
        fastest.level,
        percent(WORTH),
        percent(fastest.penetration_error_rel)
    ))
}

/// The largest part that some scenes do not read.
fn sections(content: &Content) -> Option<String> {
    let most = content.unneeded.iter().max_by_key(|u| u.bytes)?;
    let share = most.bytes as f64 / content.asset.bytes.max(1) as f64;
    (share >= WORTH).then(|| {
        format!(
            "{}, queries never read {} of the file ({}).",
            capitalised(&most.scene),
            percent(share),
            most.without
        )
    })
}

fn percent(x: f64) -> String {
    let x = 100.0 * x;
    match x {
        0.0 => "0 %".to_string(),
        x if x >= 10.0 => format!("{x:.0} %"),
        x if x >= 0.01 => format!("{x:.2} %"),
        x if x >= 0.001 => format!("{x:.3} %"),
        _ => "below 0.001 %".to_string(),
    }
}
