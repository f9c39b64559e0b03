//! The command: arguments → input → basis → bake → file → what people or machines read of it.

mod arguments;
mod output;
mod progress;

pub(crate) use arguments::Arguments;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use bdtree_build::basis::Basis;
use bdtree_build::basis::elastic::{ElasticOptions, ElasticReport, elastic_basis};
use bdtree_build::basis::given::given_basis;
use bdtree_build::error::BakeError;
use bdtree_build::input::{RawMesh, read_mesh};
use bdtree_build::pipeline::{BakeSettings, bake, default_leaf_size, write_atomically};
use bdtree_build::progress::Progress;
use bdtree_build::report::BakeReport;

/// Modes of an elastic bake that names none.
const MODES_DEFAULT: usize = 10;

/// Exit codes: 0 done, 1 bad input, 2 usage.
pub(crate) fn run(arguments: &Arguments) -> ExitCode {
    if let Err(message) = arguments.mode_count()
        && arguments.unsupported().is_none()
    {
        eprintln!("bdtree-build: --modes: {message}");
        return ExitCode::from(2);
    }
    if arguments.input.is_none() && arguments.unsupported().is_none() {
        eprintln!("bdtree-build: no INPUT: name a mesh (.obj, .obj.gz); --help shows all options");
        return ExitCode::from(2);
    }
    let progress = progress::Bar::new(arguments.quiet || arguments.json);
    match bake_file(arguments, &progress) {
        Ok(done) => {
            progress.clear();
            output::print(&done, arguments.json, arguments.quiet)
        }
        Err(error) => {
            progress.clear();
            for problem in &error.problems {
                eprintln!("bdtree-build: {problem}");
            }
            ExitCode::from(1)
        }
    }
}

/// What a finished bake has to tell.
struct Done {
    output: PathBuf,
    report: BakeReport,
    elastic: Option<ElasticReport>,
}

/// Where fields come from, and what came with them.
struct Fields {
    basis: Basis,
    kind: &'static str,
    elastic: Option<ElasticReport>,
    settings: BTreeMap<String, String>,
}

fn bake_file(arguments: &Arguments, progress: &dyn Progress) -> Result<Done, BakeError> {
    if let Some(option) = arguments.unsupported() {
        return Err(BakeError::one("input", option, "not supported yet"));
    }
    let input = arguments.input.as_deref().unwrap_or(Path::new(""));
    let output = arguments
        .output
        .clone()
        .unwrap_or_else(|| default_output(input));
    if let (Ok(from), Ok(to)) = (input.canonicalize(), output.canonicalize())
        && from == to
    {
        let place = output.display().to_string();
        return Err(BakeError::one(
            "file",
            place,
            "is the input: it would be overwritten",
        ));
    }
    let begin = Instant::now();
    progress.stage("input", None);
    let mesh = read_mesh(input)?;
    let input_seconds = begin.elapsed().as_secs_f64();

    let begin = Instant::now();
    progress.stage("basis", None);
    let mut warnings = Vec::new();
    let fields = fields(arguments, &mesh, progress, &mut warnings)?;
    let basis_seconds = begin.elapsed().as_secs_f64();

    let mut settings = BakeSettings {
        leaf_size: arguments.leaf_size.map(usize::from),
        split: arguments.split,
        threads: arguments
            .threads
            .map_or_else(available_threads, usize::from),
        basis_kind: fields.kind.to_string(),
        metadata: fields.settings,
        ..BakeSettings::default()
    };
    let leaf_size = settings
        .leaf_size
        .unwrap_or_else(|| default_leaf_size(mesh.triangles.len()));
    let shown = [
        ("leaf-size", leaf_size.to_string()),
        ("split", arguments.split.to_string()),
    ];
    for (name, value) in shown {
        settings.metadata.insert(name.to_string(), value);
    }
    let mut baked = bake(&mesh, &fields.basis, &settings, &warnings, progress)?;

    progress.stage("file", None);
    let begin = Instant::now();
    write_atomically(&output, &baked.bytes)?;
    let stages = &mut baked.report.stages;
    stages.insert("input".into(), input_seconds);
    stages.insert("basis".into(), basis_seconds);
    stages.insert("file".into(), begin.elapsed().as_secs_f64());
    Ok(Done {
        output,
        report: baked.report,
        elastic: fields.elastic,
    })
}

fn available_threads() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}

/// INPUT with `.obj` or `.obj.gz` replaced by `.bdt`.
fn default_output(input: &Path) -> PathBuf {
    let without_gz = if input
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("gz"))
    {
        input.with_extension("")
    } else {
        input.to_path_buf()
    };
    without_gz.with_extension("bdt")
}

fn fields(
    arguments: &Arguments,
    mesh: &RawMesh,
    progress: &dyn Progress,
    warnings: &mut Vec<String>,
) -> Result<Fields, BakeError> {
    let count = arguments.mode_count().ok().flatten();
    if arguments.basis.is_some() || count == Some(0) {
        for option in arguments.elastic_only() {
            warnings.push(format!("{option} is not used: only elastic modes need it"));
        }
    }
    if let Some(path) = &arguments.basis {
        let frequencies = arguments.frequencies.as_deref();
        let given = given_basis(
            path,
            arguments.basis_layout,
            frequencies,
            mesh.positions.len(),
        )?;
        warnings.extend(given.warnings);
        let mut basis = given.basis;
        if let Some(count) = count {
            let found = basis.mode_count();
            if count > found {
                let message = format!("--modes {count}, but the array holds {found} fields");
                let place = path.display().to_string();
                return Err(BakeError::one("basis", place, message));
            }
            basis.modes.truncate(count);
            basis.fields.truncate(count * basis.vertex_count);
        }
        let name = |path: &Path| {
            path.file_name()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned()
        };
        let mut settings = BTreeMap::from([("basis".to_string(), name(path))]);
        if let Some(layout) = arguments.basis_layout {
            settings.insert("basis-layout".into(), layout.to_string());
        }
        if let Some(frequencies) = frequencies {
            settings.insert("frequencies".into(), name(frequencies));
        }
        return Ok(Fields {
            basis,
            kind: "given",
            elastic: None,
            settings,
        });
    }
    if count == Some(0) {
        return Ok(Fields {
            basis: Basis {
                vertex_count: mesh.positions.len(),
                ..Basis::default()
            },
            kind: "rigid",
            elastic: None,
            settings: BTreeMap::new(),
        });
    }
    let default = ElasticOptions::default();
    let options = ElasticOptions {
        mode_count: count.unwrap_or(MODES_DEFAULT),
        resolution: arguments.resolution,
        young_pa: arguments.young.unwrap_or(default.young_pa),
        poisson: arguments.poisson.unwrap_or(default.poisson),
        density_kg_m3: arguments.density.unwrap_or(default.density_kg_m3),
        scale_m: arguments.scale.unwrap_or(default.scale_m),
        thickness: arguments.thickness,
        fixes: arguments.fix.clone(),
        memory_limit_bytes: arguments.memory_limit.saturating_mul(1 << 20),
        ..default
    };
    let (basis, report) = elastic_basis(mesh, &options, progress, warnings)?;
    let mut settings = BTreeMap::from(
        [
            ("modes", options.mode_count.to_string()),
            ("resolution", report.resolution.to_string()),
            ("young", options.young_pa.to_string()),
            ("poisson", options.poisson.to_string()),
            ("density", options.density_kg_m3.to_string()),
            ("scale", options.scale_m.to_string()),
        ]
        .map(|(name, value)| (name.to_string(), value)),
    );
    if let Some(thickness) = options.thickness {
        settings.insert("thickness".into(), thickness.to_string());
    }
    if !options.fixes.is_empty() {
        let fixes = options.fixes.iter().map(|f| f.without_folders());
        let text: Vec<String> = fixes.map(|f| f.to_string()).collect();
        settings.insert("fix".into(), text.join(" "));
    }
    Ok(Fields {
        basis,
        kind: "elastic",
        elastic: Some(report),
        settings,
    })
}
