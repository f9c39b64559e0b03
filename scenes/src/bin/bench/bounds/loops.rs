//! One lane of a node against the eight of another, in f32: the loops that are timed.

/// Lanes of a node.
pub(super) const LANES: usize = 8;

/// Eight numbers, one per lane.
pub(super) type Row = [f32; LANES];

/// Spheres of a node: centre, radius.
pub(super) type Balls = [Row; 4];

/// Slabs of a node: normal, middle, half, ‖n‖, 1/‖n‖².
pub(super) type Slabs = [Row; 7];

/// Boxes of a node in one frame: low and high ends.
pub(super) type Ends<const K: usize> = [[Row; 2]; K];

/// Boxes of a node: centre, axes by rows, half extents.
pub(super) type Cuboids = [Row; 15];

#[inline(always)]
pub(super) fn ball_test(a: &Balls, lane: usize, b: &Balls) -> [bool; LANES] {
    let [x, y, z, r] = [a[0][lane], a[1][lane], a[2][lane], a[3][lane]];
    let mut meet = [false; LANES];
    for k in 0..LANES {
        let (dx, dy, dz) = (b[0][k] - x, b[1][k] - y, b[2][k] - z);
        let reach = b[3][k] + r;
        meet[k] = dx * dx + dy * dy + dz * dz <= reach * reach;
    }
    meet
}

/// Balls, each slab against the other's ball, and (`BOTH`) against the other's slab.
#[inline(always)]
pub(super) fn slab_test<const BOTH: bool>(
    (ball_a, slab_a): &(Balls, Slabs),
    lane: usize,
    (ball_b, slab_b): &(Balls, Slabs),
) -> [bool; LANES] {
    let own: [f32; 4] = [0, 1, 2, 3].map(|i| ball_a[i][lane]);
    let cut: [f32; 7] = [0, 1, 2, 3, 4, 5, 6].map(|i| slab_a[i][lane]);
    let near = ball_test(ball_a, lane, ball_b);
    let mut gaps = [0.0_f32; LANES];
    for k in 0..LANES {
        let c = [ball_b[0][k], ball_b[1][k], ball_b[2][k]];
        let m = [slab_b[0][k], slab_b[1][k], slab_b[2][k]];
        let n_c = dot([cut[0], cut[1], cut[2]], c);
        let m_o = dot(m, [own[0], own[1], own[2]]);
        let first = (n_c - cut[3]).abs() - (ball_b[3][k] * cut[5] + cut[4]);
        let second = (m_o - slab_b[3][k]).abs() - (own[3] * slab_b[5][k] + slab_b[4][k]);
        let mut gap = first.max(second);
        if BOTH {
            let n_m = dot([cut[0], cut[1], cut[2]], m);
            let m_c = dot(m, c);
            let n_o = dot([cut[0], cut[1], cut[2]], [own[0], own[1], own[2]]);
            // n = α m + e: e·c = n·c − α m·c, ‖e‖² = ‖n‖² − α n·m; and the other way round.
            let share = n_m * slab_b[6][k];
            let across = (cut[5] * cut[5] - share * n_m).max(0.0).sqrt();
            let middle = share * (slab_b[3][k] - m_c) + n_c;
            let half = share.abs() * slab_b[4][k] + across * ball_b[3][k];
            gap = gap.max((middle - cut[3]).abs() - (cut[4] + half));
            let share = n_m * cut[6];
            let norm = slab_b[5][k];
            let across = (norm * norm - share * n_m).max(0.0).sqrt();
            let middle = share * (cut[3] - n_o) + m_o;
            let half = share.abs() * cut[4] + across * own[3];
            gap = gap.max((middle - slab_b[3][k]).abs() - (slab_b[4][k] + half));
        }
        gaps[k] = gap;
    }
    let mut meet = near;
    for k in 0..LANES {
        meet[k] &= gaps[k] <= 0.0;
    }
    meet
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(super) fn ends_test<const K: usize>(a: &Ends<K>, lane: usize, b: &Ends<K>) -> [bool; LANES] {
    let mut gap = [0.0_f32; LANES];
    for i in 0..K {
        let [low, high] = [a[i][0][lane], a[i][1][lane]];
        for k in 0..LANES {
            gap[k] = gap[k].max(b[i][0][k] - high).max(low - b[i][1][k]);
        }
    }
    gap.map(|gap| gap <= 0.0)
}

/// Separating axes: those of the faces, and (`FULL`) the products of edges.
#[inline(always)]
pub(super) fn cuboid_test<const FULL: bool>(
    a: &Cuboids,
    lane: usize,
    b: &Cuboids,
) -> [bool; LANES] {
    let own: [f32; 15] = std::array::from_fn(|i| a[i][lane]);
    let mut meet = [true; LANES];
    for k in 0..LANES {
        let d = [b[0][k] - own[0], b[1][k] - own[1], b[2][k] - own[2]];
        let half_a = [own[12], own[13], own[14]];
        let half_b = [b[12][k], b[13][k], b[14][k]];
        let mut turn = [[0.0_f32; 3]; 3];
        let mut size = [[0.0_f32; 3]; 3];
        let mut offset = [0.0_f32; 3];
        for i in 0..3 {
            let axis = [own[3 + 3 * i], own[4 + 3 * i], own[5 + 3 * i]];
            offset[i] = dot(axis, d);
            for j in 0..3 {
                turn[i][j] = dot(axis, [b[3 + 3 * j][k], b[4 + 3 * j][k], b[5 + 3 * j][k]]);
                size[i][j] = turn[i][j].abs() + 1e-6;
            }
        }
        let mut gap = 0.0_f32;
        for i in 0..3 {
            gap = gap.max(offset[i].abs() - (half_a[i] + dot(size[i], half_b)));
            let column = [turn[0][i], turn[1][i], turn[2][i]];
            let sizes = [size[0][i], size[1][i], size[2][i]];
            gap = gap.max(dot(column, offset).abs() - (half_b[i] + dot(sizes, half_a)));
        }
        if FULL {
            for i in 0..3 {
                let (i1, i2) = ((i + 1) % 3, (i + 2) % 3);
                for j in 0..3 {
                    let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
                    let reach = half_a[i1] * size[i2][j]
                        + half_a[i2] * size[i1][j]
                        + half_b[j1] * size[i][j2]
                        + half_b[j2] * size[i][j1];
                    let across = offset[i2] * turn[i1][j] - offset[i1] * turn[i2][j];
                    gap = gap.max(across.abs() - reach);
                }
            }
        }
        meet[k] = gap <= 0.0;
    }
    meet
}
