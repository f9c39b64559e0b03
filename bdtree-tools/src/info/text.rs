//! `info` for people.

use std::path::Path;

use super::report::{Bounds, Info};
use crate::output::{digits, printable, table};
use crate::q::counted;

/// Sides of a box below this, over its diagonal, are shown as 0.
const FLAT: f64 = 1e-9;

/// The facts as aligned lines, with the table of sections where it is asked for.
pub(super) fn text(path: &Path, info: &Info, sections: bool) -> String {
    let known = |text: &Option<String>| match text {
        Some(text) => printable(text),
        None => "unknown".to_string(),
    };
    let (vertices, triangles) = (
        counted(info.vertices, "vertex"),
        counted(info.triangles, "triangle"),
    );
    let basis = known(&info.basis);
    let mut facts = vec![
        ("file", path.display().to_string()),
        ("format", format!("{}, {} bytes", info.version, info.bytes)),
        ("mesh", format!("{vertices}, {triangles}")),
        ("basis", format!("{basis}, {}", counted(info.modes, "mode"))),
    ];
    if let Some(bounds) = &info.bounds {
        let told = |bounds: &Bounds| {
            let diagonal = bounds.diagonal();
            let size = bounds.size().map(|x| side(x, diagonal)).join(" x ");
            format!("{size} mesh units, diagonal {}", digits(diagonal))
        };
        let corners = |bounds: &Bounds| {
            let corners = [bounds.min, bounds.max].map(|p| p.map(digits).join(" "));
            corners.join(" to ")
        };
        match &info.bounds_at_rest {
            None => {
                facts.push(("size", told(bounds)));
                facts.push(("box", corners(bounds)));
            }
            // Queries meet the mesh as its bones carry it.
            Some(at_rest) => {
                facts.push(("size", format!("{}, bones at rest", told(at_rest))));
                facts.push(("box", corners(at_rest)));
                facts.push(("bind pose", format!("{}, before bones", told(bounds))));
                facts.push(("bind box", corners(bounds)));
            }
        }
    }
    if let Some(scale) = info.scale_m {
        facts.push(("scale", format!("1 mesh unit = {} m", digits(scale))));
    }
    if let Some(mass) = &info.mass {
        facts.extend(mass.lines());
    }
    if let Some(error) = &info.basis_error_rel {
        let place = match (error.vertex, error.frame) {
            (Some(vertex), Some(frame)) => format!(" (vertex {vertex} in frame {frame})"),
            (Some(vertex), None) => format!(" (vertex {vertex})"),
            (None, Some(frame)) => format!(" (frame {frame})"),
            (None, None) => String::new(),
        };
        let (max, rms) = (percent(error.max), percent(error.rms));
        let error = format!("at most {max} of the diagonal{place}, rms {rms}");
        facts.push(("basis error", error));
    }
    if let Some(highest) = info.highest_frequency_hz {
        facts.push(("basis ends", format!("at {} Hz", digits(highest))));
    }
    if let Some(frames) = info.frames {
        let time = match info.duration_s {
            Some(seconds) => format!("{} s", digits(seconds)),
            None => "times unknown".to_string(),
        };
        let frames = counted(frames, "frame");
        facts.push(("animation", format!("{frames}, {time}")));
    }
    if let (Some(joints), Some(bones)) = (&info.joints, info.bones) {
        let influences = info.influences_max.unwrap_or_default();
        let joints = counted(joints.len(), "joint");
        let bones = counted(bones, "bone");
        let most = counted(influences as usize, "influence");
        facts.push((
            "skin",
            format!("{joints}, {bones}, at most {most} of a vertex"),
        ));
    }
    for clip in info.clips.iter().flatten() {
        let name = printable(&clip.name);
        facts.push(("clip", format!("{name}, {} s", digits(clip.duration_s))));
    }
    let (nodes, levels) = (counted(info.nodes, "node"), counted(info.depth, "level"));
    let in_leaf = counted(info.leaf_triangles_max as usize, "triangle");
    let origin = info.origin.map(digits).join(" ");
    let groups = ["object", "group", "material"].map(|kind| {
        let of_kind = info.groups.iter().filter(|g| g.kind == kind);
        counted(of_kind.count(), kind)
    });
    let groups = format!("{} ({})", info.groups.len(), groups.join(", "));
    facts.extend([
        (
            "tree",
            format!("{nodes}, {levels}, at most {in_leaf} a leaf"),
        ),
        ("growth", growth(info)),
        ("origin", origin),
        ("stored unit", stored_unit(info.unit)),
        ("source", known(&info.source.name)),
        ("sha-256", known(&info.source.hash)),
        ("builder", known(&info.builder)),
        ("groups", groups),
    ]);
    let settings = info.settings.iter().flatten().map(|(name, value)| {
        let value = format!("{} = {}", printable(name), printable(value));
        ("setting", value)
    });
    let warnings = info.warnings.iter().flatten();
    let warnings = warnings.map(|warning| ("warning", printable(warning)));
    let mut text = lines(facts);
    text += &tables(info, sections);
    text + &lines(settings.chain(warnings))
}

/// A side of a box; 0 for what rounding leaves of a flat mesh's third one.
fn side(x: f64, diagonal: f64) -> String {
    digits(if x < FLAT * diagonal { 0.0 } else { x })
}

/// A share in per cent, three digits at most.
fn percent(share: f64) -> String {
    let x = 100.0 * share;
    format!("{} %", digits(format!("{x:.2e}").parse().unwrap_or(x)))
}

/// Mesh units per stored unit, in words.
fn stored_unit(unit: f64) -> String {
    let units = if unit == 1.0 {
        "mesh unit"
    } else {
        "mesh units"
    };
    format!("{} {units}", digits(unit))
}

/// How much spheres grow with the modes.
fn growth(info: &Info) -> String {
    let grown = info
        .levels
        .iter()
        .filter_map(|l| Some((l.spheres as f64, l.growth_mean?)));
    let (sum, count) = grown.fold((0.0, 0.0), |(sum, count), (n, growth)| {
        (sum + n * growth, count + n)
    });
    if count == 0.0 {
        let still = if info.bones.is_some() && info.modes == 0 {
            "spheres grow with the bones only: there are no modes"
        } else {
            "rigid: spheres do not grow"
        };
        return still.to_string();
    }
    let mean = sum / count;
    format!("spheres at q_range are on average {mean:.2} times as large as at rest")
}

fn lines(facts: impl IntoIterator<Item = (&'static str, String)>) -> String {
    let line = |(name, value)| format!("{name:<12} {value}\n");
    facts.into_iter().map(line).collect()
}

/// Modes, if there are any, sections, if they are asked for, and levels.
fn tables(info: &Info, sections: bool) -> String {
    let mut text = String::new();
    if info.modes > 0 {
        let optional = |x: Option<f64>| x.map_or("-".to_string(), digits);
        let heading = "mode,name,frequency [Hz],modal mass [kg],default q,q_range,q_limit";
        let modes: Vec<[String; 7]> = info
            .mode_info
            .iter()
            .enumerate()
            .map(|(j, mode)| {
                [
                    j.to_string(),
                    mode.name.as_deref().map_or("-".to_string(), printable),
                    optional(mode.frequency_hz),
                    optional(mode.modal_mass_kg),
                    optional(mode.default_q),
                    digits(info.q_range[j].into()),
                    digits(info.q_limit[j].into()),
                ]
            })
            .collect();
        // A column in which nothing is known says nothing.
        let kept: Vec<usize> = (0..7)
            .filter(|c| modes.iter().any(|row| row[*c] != "-"))
            .collect();
        let headings: Vec<&str> = heading.split(',').collect();
        let heading: Vec<&str> = kept.iter().map(|c| headings[*c]).collect();
        let rows = modes.iter().map(|row| {
            let cells = kept.iter().map(|c| row[*c].clone());
            cells.collect::<Vec<_>>()
        });
        text += &table("modes", &heading.join(","), rows);
    }
    if sections {
        let sections = info.sections.iter();
        let sections =
            sections.map(|s| vec![s.kind.clone(), s.offset.to_string(), s.bytes.to_string()]);
        text += &table("sections", "kind,offset,bytes", sections);
    }
    let radius = |x: Option<f64>| x.map_or("-".to_string(), digits);
    let levels = info.levels.iter().map(|level| {
        vec![
            level.level.to_string(),
            level.spheres.to_string(),
            radius(level.radius_mean),
            radius(level.radius_max),
            level
                .growth_mean
                .map_or("-".to_string(), |growth| format!("{growth:.3}")),
        ]
    });
    text + &table(
        "levels",
        "level,spheres,mean radius,largest radius,growth at q_range",
        levels,
    )
}

#[cfg(test)]
mod tests {
    use super::{percent, side};

    #[test]
    fn a_flat_mesh_has_a_side_of_0() {
        assert_eq!(side(5.551e-17, 1.89), "0");
        assert_eq!(side(1.6, 1.89), "1.6");
    }

    #[test]
    fn shares_are_told_as_the_bake_tells_them() {
        for (share, text) in [(0.0536211, "5.36 %"), (0.002, "0.2 %"), (0.0, "0 %")] {
            assert_eq!(percent(share), text);
        }
    }
}
