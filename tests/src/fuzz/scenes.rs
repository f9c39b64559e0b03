//! Scenes to begin with, and the assets that they name.

use std::fs;
use std::path::Path;

use serde_json::json;

use bdtree_fixtures::bake;

/// Writes the assets of [`seeds`] into a folder: with three modes, rigid, with frames, damaged.
pub(super) fn write_assets(folder: &Path) {
    let ball = bake::bumpy_sphere(5, 1);
    let moving = bake::baked(&ball, &bake::smooth_basis(&ball, 3, 1));
    let small = bake::bumpy_sphere(3, 2);
    let rigid = bake::baked(&small, &bake::rigid(&small));
    let frames = bake::with_frames(bake::smooth_basis(&small, 2, 1), 3, 0.5, 1);
    let frames = bake::baked(&small, &frames);
    let mut damaged = moving.asset().bytes().to_vec();
    let last = damaged.len() - 1;
    damaged[last] ^= 1;
    let files: [(&str, &[u8]); 5] = [
        ("a.bdt", moving.asset().bytes()),
        ("rigid.bdt", rigid.asset().bytes()),
        ("frames.bdt", frames.asset().bytes()),
        ("damaged.bdt", &damaged),
        ("empty.bdt", &[]),
    ];
    for (name, bytes) in files {
        fs::write(folder.join(name), bytes).expect("an asset");
    }
}

/// Scenes with every kind of instance and query.
pub(super) fn seeds() -> Vec<Vec<u8>> {
    let all = json!({
        "instances": [
            {"name": "a", "asset": "a.bdt", "q": [0.5, -1, 0.25],
             "rotation": [0, 0.6, 0, 0.8], "translation": [0.25, 0, -0.5], "scale": 1.5},
            {"name": "b", "asset": "frames.bdt", "frame": 1},
            {"name": "c", "asset": "rigid.bdt", "q": [], "translation": [1.5, 0, 0]}],
        "options": {"max_depth": null},
        "queries": [
            {"ball": {"instance": "a", "center": [0.5, 0, 1], "radius": 0.75}},
            {"closest": {"instance": "b", "point": [2, 1, 0], "max_distance": 4}},
            {"ray": {"instance": "c", "origin": [1.5, 0, 5], "direction": [0, 0, -2]}},
            {"plane": {"instance": "a", "normal": [0, 2, 0], "offset": -0.25}},
            {"frustum": {"instance": "b", "planes": [[1, 0, 0, 0.5], [-1, 0, 0, 0.5],
                [0, 1, 0, 1], [0, -1, 0, 1], [0, 0, 1, 2], [0, 0, -1, 2]]}},
            {"pair": {"a": "a", "b": "c", "tolerance": 0.0}},
            {"pair": {"a": "a", "b": "b", "contacts": true}},
            {"distance": {"a": "b", "b": "c", "max_distance": 10}},
            {"capsule": {"instance": "c", "point1": [0, 0, 0], "point2": [2, 0, 0],
                "radius": 0.25}},
            {"box": {"instance": "a", "center": [0, 0, 0], "rotation": [0, 0, 0, 1],
                "half_extents": [1, 0.5, 0.25]}},
            {"rays": {"instance": "a", "origins": [[0, 0, 5], [0, 5, 0]],
                "directions": [[0, 0, -1], [0, -1, 0.1]], "mode": "all"}}]});
    let plain = json!({
        "instances": [{"name": "a", "asset": "a.bdt", "q": [1, 1, -1]}],
        "queries": [
            {"ball": {"instance": "a", "center": [1, 0, 0], "radius": 0.5}},
            {"plane": {"instance": "a", "normal": [1, 1, 1], "offset": 0.5}},
            {"closest": {"instance": "a", "point": [3, 0, 0]}}]});
    let bounded = json!({
        "instances": [
            {"name": "a", "asset": "a.bdt"},
            {"name": "bad", "asset": "rigid.bdt", "translation": [0.5, 0, 0]}],
        "options": {"max_visits": 5},
        "queries": [
            {"ball": {"instance": "a", "center": [1, 0, 0], "radius": 0.5}},
            {"distance": {"a": "a", "b": "bad"}},
            {"rays": {"instance": "bad", "origins": [], "directions": [], "mode": "any"}}]});
    let levels = json!({
        "instances": [{"name": "a", "asset": "a.bdt"}, {"name": "b", "asset": "rigid.bdt"}],
        "options": {"max_depth": 1},
        "queries": [
            {"pair": {"a": "a", "b": "b", "tolerance": 0.1}},
            {"box": {"instance": "a", "center": [0, 0, 0], "half_extents": [1, 0.5, 0.25]}},
            {"capsule": {"instance": "a", "point1": [0, 0, 0], "point2": [2, 0, 0], "radius": 1}}]});
    let refused = json!({
        "instances": [
            {"name": "a", "asset": "damaged.bdt"},
            {"name": "b", "asset": "empty.bdt"},
            {"name": "c", "asset": "missing.bdt"}],
        "queries": [{"pair": {"a": "a", "b": "b"}}]});
    [all, plain, bounded, levels, refused]
        .map(|scene| scene.to_string().into_bytes())
        .into()
}
