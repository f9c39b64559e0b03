//! Pictures side by side.

use std::error::Error;
use std::path::Path;

use bdtree_output::write_whole;
use bdtree_render::tightness::Scale;
use bdtree_render::{
    Box3, Camera, Framing, Image, Place, Scene, SkinnedMesh, Sphere, Studio, TextSize,
    ViewDirection, draw_scale,
};
use bdtree_runtime::{Asset, BoneMatrices, Transform, VertexId};

use bdtree_scenes::hierarchies::Found;

/// One picture of a figure.
#[derive(Clone)]
pub(crate) struct Cell<'q> {
    pub(crate) title: String,
    pub(crate) q: &'q [f32],
    /// `None`: the mesh.
    pub(crate) spheres: Option<Vec<Found>>,
}

impl<'q> Cell<'q> {
    pub(crate) fn of(title: String, q: &'q [f32], spheres: Option<Vec<Found>>) -> Self {
        Self { title, q, spheres }
    }
}

/// Everything that all pictures share.
pub(crate) struct Stage<'a> {
    asset: Asset<'a>,
    studio: Studio,
    mesh: SkinnedMesh,
    middle: [f64; 3],
    size: f64,
    /// All deformed vertices' box, as drawn.
    bounds: Box3,
    view: [f32; 2],
    cell: u32,
}

const WHITE: [u8; 4] = [255; 4];
const DARK: [u8; 3] = [20, 24, 32];
const GREY: [u8; 3] = [80, 86, 96];
const TEXT: TextSize = TextSize::Small;

impl<'a> Stage<'a> {
    /// For an asset at these q, seen from `view` (degrees around y and from above).
    pub(crate) fn new(
        asset: Asset<'a>,
        poses: &[&[f32]],
        view: [f32; 2],
        cell: u32,
    ) -> Result<Self, Box<dyn Error>> {
        let mut memory = vec![0.0; asset.pose_len()];
        let mut bounds = Box3::EMPTY;
        for q in poses {
            let pose = asset.pose(q, Transform::IDENTITY, &mut memory)?;
            for v in 0..asset.vertex_count() as u32 {
                bounds = bounds.with(pose.deformed_stored(VertexId(v))?);
            }
        }
        let (middle, size) = (bounds.middle(), bounds.half_diagonal());
        let about = |p: [f32; 3]| [0, 1, 2].map(|k| (p[k] - middle[k]) / size);
        let bounds = Box3::around([about(bounds.low), about(bounds.high)]);
        let studio = Studio::open()?;
        let mesh = studio.skinned(&asset)?;
        Ok(Self {
            asset,
            studio,
            mesh,
            middle: middle.map(f64::from),
            size: f64::from(size),
            bounds,
            view,
            cell,
        })
    }

    /// A cell's spheres as they are drawn.
    fn spheres(&self, cell: &Cell<'_>) -> Vec<Sphere> {
        let (middle, size) = (self.middle, self.size);
        let found = cell.spheres.iter().flatten();
        found
            .map(|found| {
                let [r, g, b] = Scale::Paper.colour(found.growth);
                Sphere {
                    center: [0, 1, 2].map(|k| ((found.center[k] - middle[k]) / size) as f32),
                    radius: (found.radius / size) as f32,
                    colour: [r, g, b, 255],
                }
            })
            .collect()
    }

    /// The camera that sees everything in a figure.
    fn camera(&self, rows: &[(String, Vec<Cell<'_>>)]) -> Camera {
        let cells = rows.iter().flat_map(|(_, cells)| cells);
        let spheres = cells.flat_map(|cell| self.spheres(cell));
        let mut balls: Vec<_> = spheres.map(|s| (s.center, s.radius)).collect();
        // Geometry lies within its spheres; a figure of geometry alone has only that.
        if balls.is_empty() {
            balls = vec![(self.bounds.middle(), self.bounds.half_diagonal())];
        }
        let [azimuth, elevation] = self.view;
        let mut framing = Framing::new(ViewDirection::new(azimuth, elevation), 1.0);
        for (center, radius) in balls {
            framing.hold(center.map(f64::from), f64::from(radius));
        }
        // They are in drawn units as they are.
        framing.camera(&Place {
            middle: [0.0; 3],
            size: 1.0,
        })
    }

    fn picture(&mut self, cell: &Cell<'_>, camera: &Camera) -> Result<Image, Box<dyn Error>> {
        let (middle, size) = (self.middle, self.size);
        let spheres = self.spheres(cell);
        // From the world to stored units, and on to the picture's.
        let (unit, origin) = (self.asset.unit(), self.asset.origin());
        let scale = 1.0 / (unit * size);
        let transform = Transform {
            translation: [0, 1, 2].map(|k| -origin[k] * scale - middle[k] / size),
            scale,
            ..Transform::IDENTITY
        };
        let rest = BoneMatrices::Rest;
        self.mesh
            .pose_with_bones(&self.studio.gpu, &self.asset, cell.q, rest, transform)?;
        let meshes = [&self.mesh.mesh];
        let scene = Scene {
            ground: None,
            background: WHITE,
            meshes: if cell.spheres.is_none() { &meshes } else { &[] },
            spheres: &spheres,
            lines: &[],
        };
        Ok(self.studio.picture([self.cell; 2], camera, &scene)?)
    }

    /// Draws a figure: rows of pictures with names, below them the scale.
    pub(crate) fn figure(
        &mut self,
        title: &str,
        rows: &[(String, Vec<Cell<'_>>)],
        path: &Path,
    ) -> Result<(), Box<dyn Error>> {
        let (line, cell) = (TEXT.line(), i64::from(self.cell));
        let columns = rows.iter().map(|(_, cells)| cells.len()).max().unwrap_or(0) as i64;
        let margin = line;
        let row_height = cell + 2 * line + line / 2;
        let head = margin + 2 * line;
        let foot = 4 * line;
        let size = [
            columns * cell + 2 * margin,
            head + rows.len() as i64 * row_height + foot + margin,
        ];
        let camera = self.camera(rows);
        let mut image = Image::filled(size.map(|n| n as u32), WHITE);
        image.text([margin, margin], title, TextSize::Medium, DARK);
        for (i, (name, cells)) in (0..).zip(rows) {
            let top = head + i * row_height;
            image.text([margin, top], name, TEXT, DARK);
            for (j, cell_of) in (0..).zip(cells) {
                let left = margin + j * cell;
                image.paste([left, top + 2 * line], &self.picture(cell_of, &camera)?);
                let middle = left + (cell - TEXT.width(&cell_of.title)) / 2;
                image.text([middle, top + line + line / 4], &cell_of.title, TEXT, GREY);
            }
        }
        let meaning = "radius over the undeformed wrapped sphere's (BD-Tree as in the paper)";
        let corner = [margin, size[1] - margin - foot + line / 2];
        draw_scale(
            &mut image,
            corner,
            [24 * line, line * 3 / 4],
            (Scale::Paper, meaning),
            TEXT,
        );

        write_whole(path, |w| image.write_png(w))?;
        println!("\nwrote {}", path.display());
        Ok(())
    }
}
