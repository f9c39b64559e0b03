//! Hard rigid meshes in the product and in the libraries that people use (feature `peers`): which rays
//! slip through a closed mesh, how far distances are off, what touching triangles and broken input do.
//!
//! All get the same mesh in world coordinates, rounded to what each computes with, and the same rays in
//! f32. References are exact: rational arithmetic for distances; for rays, a place inside a closed
//! mesh, from where each must hit.

mod closest;
mod libraries;
mod rays;
#[cfg(feature = "peers")]
mod touching;

use std::process::{Command, Stdio};
use std::time::Duration;

use bdtree_build::input::{RawMesh, read_mesh};
use bdtree_fixtures::models;

use libraries::{LIBRARIES, build};

use crate::prelude::*;

/// How long a library may take over a broken mesh.
const PATIENCE: Duration = Duration::from_secs(20);

#[derive(Args)]
pub(crate) struct Arguments {
    /// Rays per mesh from inside a closed mesh
    #[arg(long, default_value_t = 100_000)]
    rays: usize,
    /// Points per mesh whose distance is asked for
    #[arg(long, default_value_t = 200)]
    points: usize,
    /// One broken mesh in one library, and nothing else: a process of its own
    #[arg(long, hide = true, num_args = 2, value_names = ["CASE", "LIBRARY"])]
    broken: Option<Vec<String>>,
}

fn fixture(name: &str) -> Result<RawMesh> {
    Ok(read_mesh(&models::path(name))?)
}

pub(crate) fn run(arguments: &Arguments) -> Result<Vec<Table>> {
    if let Some(words) = &arguments.broken {
        println!("{}", broken_here(&words[0], &words[1])?);
        std::process::exit(0);
    }
    let about = |(name, precision): &_| row! {"library" => *name, "coordinates" => *precision};
    let libraries: Vec<Row> = LIBRARIES.iter().map(about).collect();
    let missed = format!("Rays from inside that miss, of {}", arguments.rays);
    let off = "Distance of a point, largest error over the size of the mesh";
    let mut broken = Vec::new();
    for case in BROKEN {
        let mut row = row! {"input" => case};
        for (library, _) in LIBRARIES {
            row.extend(row! {*library => broken_elsewhere(case, library)?});
        }
        broken.push(row);
    }
    Ok(vec![
        table("libraries", "Who takes part", &libraries),
        table("rays", missed, &rays::rows(arguments.rays)?),
        table("closest", off, &closest::rows(arguments.points)?),
        #[cfg(feature = "peers")]
        table("touching", touching::TITLE, &[touching::row()?]),
        table("broken", "Broken input", &broken),
    ])
}

/// Meshes that are none.
const BROKEN: [&str; 4] = [
    "NaN in a vertex",
    "infinite vertex",
    "index out of range",
    "no triangles",
];

/// Builds a broken mesh in a process of its own, which may panic, abort or hang.
fn broken_elsewhere(case: &str, library: &str) -> Result<String> {
    let mut child = Command::new(std::env::current_exe()?)
        .args(["hard-cases", "--broken", case, library])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()?;
    let start = Instant::now();
    while child.try_wait()?.is_none() {
        if start.elapsed() > PATIENCE {
            child.kill()?;
            child.wait()?;
            return Ok(format!("does not return within {} s", PATIENCE.as_secs()));
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let output = child.wait_with_output()?;
    Ok(match output.status.code() {
        Some(0) => String::from_utf8_lossy(&output.stdout).trim().to_string(),
        Some(_) => "panics".to_string(),
        None => "crashes".to_string(),
    })
}

/// Builds a broken mesh and asks for rays at the corners that are sound, from the middle.
fn broken_here(case: &str, library: &str) -> Result<String> {
    let mut mesh = fixture("cube")?;
    match case {
        "NaN in a vertex" => mesh.positions[7][1] = f64::NAN,
        "infinite vertex" => mesh.positions[7][1] = f64::INFINITY,
        "index out of range" => mesh.triangles[20][1] = 1_000_000,
        _ => mesh.triangles.clear(),
    }
    let sound: Vec<[f64; 3]> = (mesh.triangles.iter())
        .filter(|t| t.iter().all(|v| *v != 7 && *v < 1_000_000))
        .map(|t| {
            let corners = t.map(|v| mesh.positions[v as usize]);
            [0, 1, 2].map(|k| (corners[0][k] + corners[1][k] + corners[2][k]) / 3.0)
        })
        .collect();
    // Those who take corners and not indices fail here, before they are asked.
    if case == "index out of range" && library == "obvhs" {
        return Ok("takes no indices".to_string());
    }
    Ok(match build(library, &mesh) {
        Err(error) => format!("error: {error}"),
        Ok(mut library) => {
            let missed = sound.iter().filter(|target| {
                let direction = target.map(|x| x as f32);
                library.ray([0.0; 3], direction).is_none()
            });
            let (missed, all) = (missed.count(), sound.len());
            format!("accepted; {missed} of {all} rays at sound triangles miss")
        }
    })
}
