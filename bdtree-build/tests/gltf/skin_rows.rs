//! What every file with a skin holds, by brute force over the vertices below each lane (SPEC 6.10, 7.7, 7.8).

use std::path::Path;

use bdtree_build::pipeline::{Baked, bake};
use bdtree_build::progress::Silent;
use bdtree_build::recipe::{Elastic, Morphs, Motion, Recipe};
use bdtree_fixtures::lanes;
use bdtree_runtime::{Asset, Model, VertexId};

/// u, half the spacing of f32 at 1.
const U: f64 = 1.0 / (1 << 24) as f64;

/// A file as the command bakes it without options.
pub(crate) fn baked(path: &Path) -> Baked {
    let motion = Motion::MorphsElseSkin(Morphs::default(), Elastic::default());
    let recipe = Recipe::of_surface(path, motion);
    bake(&recipe, &Silent).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// The model of a bake, whose skin was checked.
pub(crate) fn checked(baked: &Baked) -> Model {
    let model = Model::from_bytes(&baked.bytes).expect("opens");
    let asset = model.asset();
    check_bones(asset);
    let mut most = 0;
    for node in 0..asset.nodes().len() {
        most = most.max(check_node(asset, node));
    }
    let record = asset.skin_record().expect("a skin");
    assert_eq!(record.node_bones_max as usize, most);
    model
}

/// The weight of a bone on a vertex.
fn weight(asset: &Asset<'_>, vertex: usize, bone: u16) -> f32 {
    let influences = asset
        .influences(VertexId(vertex as u32))
        .expect("in the file");
    let found = influences.iter().find(|i| i.bone == bone);
    found.map_or(0.0, |influence| influence.weight)
}

fn check_bones(asset: &Asset<'_>) {
    let record = asset.skin_record().expect("a skin");
    let (mut most, mut defect) = (0, 0.0_f64);
    for i in 0..asset.vertex_count() {
        let influences = asset.influences(VertexId(i as u32)).expect("in the file");
        most = most.max(influences.len());
        assert!(
            influences
                .windows(2)
                .all(|pair| pair[0].bone < pair[1].bone)
        );
        let sum: f64 = influences.iter().map(|i| f64::from(i.weight)).sum();
        defect = defect.max((sum - 1.0).abs());
        for influence in influences {
            assert!((2.0_f32.powi(-32)..=2.0).contains(&influence.weight));
            let bone = &asset.bones()[usize::from(influence.bone)];
            for k in 0..3 {
                let x = asset.positions()[i][k];
                assert!(bone.low[k].get() <= x && x <= bone.high[k].get());
            }
        }
    }
    check_cores(asset);
    assert_eq!(record.influences_max as usize, most);
    assert!(f64::from(record.weight_defect) >= defect * (1.0 - 1e-12));
    assert!(f64::from(record.weight_defect) <= defect * (1.0 + 1e-6) + 1e-12);
}

/// Core boxes hold vertices but for minor_share of their weights, which is the least number, and at most 0.15.
fn check_cores(asset: &Asset<'_>) {
    let mut largest = 0.0_f64;
    for i in 0..asset.vertex_count() {
        let p = asset.positions()[i];
        let influences = asset.influences(VertexId(i as u32)).expect("in the file");
        let outside = influences.iter().filter(|influence| {
            let bone = &asset.bones()[usize::from(influence.bone)];
            !(0..3).all(|k| bone.core_low[k].get() <= p[k] && p[k] <= bone.core_high[k].get())
        });
        largest = largest.max(outside.map(|i| f64::from(i.weight)).sum());
    }
    let share = f64::from(asset.skin_record().expect("a skin").minor_share);
    assert!(largest <= share && share <= 0.150_001, "{largest} {share}");
}

/// Number of entries of the node.
fn check_node(asset: &Asset<'_>, node: usize) -> usize {
    let own = asset
        .node_bones(node as u32)
        .expect("in the file")
        .expect("a skin");
    let record = &asset.nodes()[node];
    for lane in 0..8 {
        let [spread, defect] = [0, 1].map(|row| own.fixed[row][lane]);
        let rows = own
            .weights
            .iter()
            .map(|rows| [rows[0][lane], rows[1][lane]]);
        if (record.inner_mask | record.leaf_mask) >> lane & 1 == 0 {
            assert_eq!([spread, defect], [0.0; 2]);
            assert!(rows.flatten().all(|w| w == 0.0));
            continue;
        }
        let bones: Vec<(u16, [f32; 2])> = (own.entries.iter().zip(rows))
            .map(|(entry, rows)| (entry[lane], rows))
            .filter(|(_, [middle, gap])| [*middle, *gap] != [0.0; 2])
            .collect();
        let vertices = lanes::vertices(asset, node, lane);
        let weights = |bone: u16| vertices.iter().map(move |&v| weight(asset, v, bone));
        let mut carrying: Vec<u16> = (0..asset.bone_count() as u16)
            .filter(|&bone| weights(bone).any(|w| w > 0.0))
            .collect();
        let mut named: Vec<u16> = bones.iter().map(|(bone, _)| *bone).collect();
        named.sort_unstable();
        carrying.sort_unstable();
        assert_eq!(named, carrying, "node {node}, lane {lane}");
        let sum: f64 = bones
            .iter()
            .map(|(_, [middle, _])| f64::from(*middle))
            .sum();
        assert!(
            bones.is_empty() || (sum - 1.0).abs() <= (own.entries.len() + 4) as f64 * U,
            "{sum}"
        );
        for &(bone, [middle, gap]) in &bones {
            let least = weights(bone).fold(f32::INFINITY, f32::min);
            let largest = weights(bone).fold(0.0, f32::max);
            let [least, largest, middle] = [least, largest, middle].map(f64::from);
            let apart = (largest - middle).max(middle - least);
            let gap = f64::from(gap);
            assert!(
                apart <= gap && gap <= apart * (1.0 + 1e-6) + 2.0 * U,
                "{apart} {gap}"
            );
        }
        let (mut most, mut off) = (0.0_f64, 0.0_f64);
        for &vertex in &vertices {
            let distances = bones.iter().map(|&(bone, [middle, _])| {
                (f64::from(weight(asset, vertex, bone)) - f64::from(middle)).abs()
            });
            most = most.max(distances.sum());
            let influences = asset
                .influences(VertexId(vertex as u32))
                .expect("in the file");
            let sum: f64 = influences.iter().map(|i| f64::from(i.weight)).sum();
            off = off.max((sum - 1.0).abs());
        }
        let (spread, defect) = (f64::from(spread), f64::from(defect));
        assert!(
            spread >= most * (1.0 - 1e-12) && spread <= most * (1.0 + 1e-6),
            "{spread} {most}"
        );
        assert!(
            defect >= off - 1e-12 && defect <= off * (1.0 + 1e-6) + 1e-12,
            "{defect} {off}"
        );
    }
    own.entries.len()
}
