//! The time that a picture of the paper's 3601 chairs takes (P48).

use std::error::Error;
use std::io::BufWriter;
use std::path::PathBuf;

use bdtree_measure::stats::median;
use bdtree_output::write_whole;
use bdtree_render::{Crowd, CrowdPicture, Floor, Gpu, Shot};
use bdtree_runtime::Model;
use bdtree_scenes::film::{self, Heap};
use bdtree_scenes::report::{Report, Row, table};
use bdtree_scenes::{row, tables};
use clap::Args;

#[derive(Args)]
pub(crate) struct Arguments {
    /// A baked file instead of the chair of fixtures/ with ten vibration modes
    #[arg(long)]
    asset: Option<PathBuf>,
    /// Number of bodies
    #[arg(long, default_value_t = 3601)]
    instances: usize,
    /// Pictures per figure, of which the median counts, after one that does not; 0: that one counts
    #[arg(long, default_value_t = 5)]
    rounds: usize,
    /// Width and height in pixels
    #[arg(long, value_delimiter = 'x', default_value = "1280x720")]
    size: Vec<u32>,
    /// Of the heap
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Memory for deformed vertices on the device, in MiB (one chair at least)
    #[arg(long, default_value_t = Crowd::BATCH_BYTES >> 20)]
    batch_mib: u64,
    /// By how many pixels corners of far bodies may be moved for fewer triangles (0: all triangles), a figure for each
    #[arg(long, value_delimiter = ',', default_value = "0,2")]
    coarser_by: Vec<f64>,
    /// Also draws all chairs, those too that cannot be seen
    #[arg(long)]
    all: bool,
    /// A PNG file for the picture
    #[arg(long)]
    picture: Option<PathBuf>,
    /// Folder for crowd.json and its tables (CSV)
    #[arg(long)]
    out: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let [width, height] = arguments.size[..] else {
        return Err("--size: width x height".into());
    };
    let model = match &arguments.asset {
        Some(path) => Model::read(path)?,
        None => tables::chair()?,
    };
    let heap = Heap::new(model.asset(), arguments.instances, arguments.seed)?;
    let bodies = heap.bodies();
    let gpu = Gpu::offscreen()?;
    let info = gpu.adapter.get_info();
    let mut crowd = Crowd::new(gpu, std::slice::from_ref(&model), arguments.batch_mib << 20)?;
    let mut shot = shot([width, height], &heap);
    shot.bodies = &bodies;
    let mut rows = Vec::new();
    let mut picture = None;
    let seen = arguments.coarser_by.iter().map(|by| (true, *by));
    for (culls, coarser_by) in seen.chain(arguments.all.then_some((false, 0.0))) {
        (shot.culls, shot.coarser_by) = (culls, coarser_by);
        let first = crowd.picture(&shot)?;
        let mut all = (0..arguments.rounds)
            .map(|_| Ok(crowd.picture(&shot)?))
            .collect::<Result<Vec<_>, Box<dyn Error>>>()?;
        let whole = picture.iter().filter(|_| !culls);
        if all.iter().chain(whole).any(|p| p.image != first.image) {
            return Err("pictures of the same bodies differ".into());
        }
        if all.is_empty() {
            all.push(first.clone());
        }
        let what = match (culls, coarser_by > 0.0) {
            (true, false) => "seen".to_string(),
            (true, true) => format!("seen, corners moved by {coarser_by} pixels at most"),
            _ => "all".to_string(),
        };
        rows.push(figures(what, &first, &all));
        // Of all triangles, where they are drawn.
        if coarser_by == 0.0 || picture.is_none() {
            picture = Some(first);
        }
    }
    if let (Some(path), Some(picture)) = (&arguments.picture, &picture) {
        write_whole(path, |out| picture.image.write_png(BufWriter::new(out)))?;
    }
    let (memory, asset) = (crowd.memory(), model.asset());
    let mega = |bytes: u64| bytes as f64 / 1e6;
    let about = row! {
        "device" => format!("{} ({:?}, {} {})", info.name, info.device_type, info.driver, info.driver_info),
        "bodies" => arguments.instances, "vertices each" => asset.vertex_count(),
        "triangles each" => asset.triangle_count(), "modes" => asset.mode_count(),
        "picture" => format!("{width} x {height}, 4 samples"),
        "pictures, of which the median counts" => arguments.rounds.max(1),
        "asset, MB" => mega(memory.assets), "batch, MB" => mega(memory.batches),
        "pictures, MB" => mega(memory.pictures),
    };
    let found = vec![
        table("device", "Device and memory", &[about]),
        table("crowd", "Time of a picture by the clock, in ms", &rows),
    ];
    Report::of_tables("crowd", found).show(arguments.out.as_deref())
}

/// The heap from near, a little from above: its sides are beyond the picture's edges.
fn shot(size: [u32; 2], heap: &Heap) -> Shot<'static> {
    let (radius, height) = (heap.radius as f32, heap.height as f32);
    let eye = [0.35 * radius, 0.95 * height + 0.25 * radius, 1.7 * radius];
    let target = [0.0, 0.3 * height, 0.0];
    Shot {
        background: film::BACKGROUND,
        floor: Some(Floor {
            height: 0.0,
            middle: [0.0; 2],
            radius: 1.6 * radius,
            colour: film::FLOOR,
        }),
        ..Shot::new(size, film::view(eye, target))
    }
}

fn figures(what: String, first: &CrowdPicture, all: &[CrowdPicture]) -> Row {
    let ms = |of: fn(&CrowdPicture) -> f64| 1e3 * median(&all.iter().map(of).collect::<Vec<_>>());
    let mut row = row! {
        "bodies" => what,
        "drawn" => first.drawn, "outside by sphere" => first.culled_by_sphere,
        "by tree" => first.culled_by_tree,
        "triangles drawn" => first.triangles, "batches" => first.batches,
        "total" => ms(|p| p.times.total()), "find" => ms(|p| p.times.cull),
        "deform and draw" => ms(|p| p.times.draw),
    };
    if first.times.device.is_some() {
        row.extend(row! {"by the device's clock" => ms(|p| p.times.device.unwrap_or(f64::NAN))});
    }
    row.extend(row! {"read back" => ms(|p| p.times.read_back)});
    row
}
