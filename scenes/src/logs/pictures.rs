//! What drawing chairs takes, with small spheres for contacts (P48).

use std::error::Error;

use super::Pictures;
use crate::chairs::{Chairs, Kind};
use crate::falling::Scene;
use crate::falling::log::Numbers;
use crate::falling::show::{Drawn, Show};

pub(super) fn measure(of: &Pictures) -> Result<(), Box<dyn Error>> {
    let begin = &of.begin;
    let [width, height] = of.size[..] else {
        return Err("--size: width x height".into());
    };
    bdtree_output::check_writable(&of.file)?;
    let model = begin.model()?;
    let columns = [&["step", "repeat", "contacts"], Drawn::NAMES].concat();
    let mut table = begin.table("logs pictures", &columns);
    table.say("size", format!("{width} x {height}"));
    let mut show: Option<Show> = None;
    for path in &of.checkpoints {
        let mut scene = Chairs::of_checkpoint(path, Kind::Deformable, &model, begin.threads)?;
        let failed = |error| format!("{}: {error}", path.display());
        scene.add_due()?;
        // Contacts are those of a step.
        scene.world_mut().step().map_err(failed)?;
        let show = match &mut show {
            Some(show) => show,
            none => {
                let mut first = Show::new(&scene, [width, height])?;
                table.say("adapter", first.adapter());
                let contacts = first.contacts(&scene);
                // Shaders are compiled for the first one, which does not count.
                first.picture(&scene, &contacts)?;
                none.insert(first)
            }
        };
        let contacts = show.contacts(&scene);
        for repeat in 1..=begin.repeat {
            show.drawn.clear();
            show.picture(&scene, &contacts)?;
            let own = [
                scene.world().steps() as f64,
                f64::from(repeat),
                contacts.len() as f64,
            ];
            let drawn = show.drawn.iter().flat_map(Numbers::numbers);
            table.rows.push(own.into_iter().chain(drawn).collect());
            table.write(&of.file)?;
        }
    }
    Ok(())
}
