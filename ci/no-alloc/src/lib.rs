//! Links `bdtree-runtime` and `bdtree-dynamics` without std and without a global allocator, and asks with them what a program
//! asks that has no heap, so that generic code is compiled too. A crate below this one that links `alloc` fails the build ("no
//! global memory allocator found"), one that links `std` collides with the panic handler.
#![no_std]

use bdtree_dynamics::{ContactLaw, FrameMass, FrameState, Oscillator, StrainLimit};
use bdtree_runtime::{
    Asset, Ball, CacheSize, Contact, Coverage, Cuboid, Motion, PairFront, Proxy, QueryError, Ray, RefinedPose,
    Sink, SliceSink, StepCache, Transform, Workspace, broad, include_bdt, studies,
};
use core::ops::ControlFlow;
use nalgebra::{UnitQuaternion, Vector3};

#[cfg(feature = "counter-example")]
extern crate alloc;

#[cfg(feature = "counter-example")]
#[unsafe(no_mangle)]
extern "C" fn allocate(count: usize) -> usize {
    alloc::vec![0_u8; count].len()
}

/// A sink of the program's own.
struct Count(usize);

impl<T> Sink<T> for Count {
    fn push(&mut self, _item: T) -> ControlFlow<()> {
        self.0 += 1;
        ControlFlow::Continue(())
    }
}

const CACHE: CacheSize = CacheSize {
    nodes: 8,
    leaves: 8,
};

/// The number of things that queries find in memory of fixed size, or -1.
#[unsafe(no_mangle)]
extern "C" fn ask() -> isize {
    let bytes = include_bdt!("../../../fixtures/golden/sphere.bdt");
    let Ok(asset) = Asset::open(bytes) else {
        return -1;
    };
    match one(&asset).and_then(|found| Ok(found + two(&asset)?)) {
        Ok(found) => found as isize,
        Err(_) => -1,
    }
}

/// A body with a mode that bounces on the ground for a while; its height.
#[unsafe(no_mangle)]
extern "C" fn bounce(steps: u32) -> f64 {
    let (h, weight) = (0.01, Vector3::new(0.0, -19.62, 0.0));
    let mass = FrameMass {
        mass_kg: 2.0,
        moments: Vector3::new(1.0, 2.0, 2.5),
    };
    let mode = Oscillator {
        omega_rad_s: 30.0,
        decay_per_s: 1.0,
    };
    let Ok(mode) = mode.transition(h) else {
        return -1.0;
    };
    let limit = StrainLimit(0.1);
    let spring = ContactLaw::default().spring(mass.mass_kg, h);
    let mut frame = FrameState::at(Vector3::new(0.0, 1.0, 0.0), UnitQuaternion::identity());
    let mut state = [0.0; 2];
    for _ in 0..steps {
        let free = frame.after(&mass, weight, Vector3::zeros(), h);
        let response = 0.5 * h * h / mass.mass_kg;
        let force = spring.force(-frame.position.y, -free.position.y, response, h);
        let force = Vector3::new(0.0, force, 0.0);
        frame = frame.after(&mass, weight + force, Vector3::zeros(), h);
        state = mode.apply(state, limit.slope(state[0]) * force.y);
    }
    frame.position.y + limit.q(state[0])
}

/// Queries of one mesh: plain, with what a step keeps, down to a level, within a budget.
fn one(asset: &Asset<'_>) -> Result<usize, QueryError> {
    let (mut numbers, mut memory) = ([0.0; 16], [0; 8192]);
    let mut kept = [0; CACHE.bytes()];
    let Ok(pose) = asset.pose(&[0.2, -0.1, 0.3], Transform::IDENTITY, &mut numbers) else {
        return Ok(0);
    };
    let mut workspace = Workspace::in_bytes(&mut memory);
    let mut cache = StepCache::in_bytes(&mut kept, CACHE)?;
    cache.start(&pose);
    let mut slots = [Contact::EMPTY; 8];
    let mut contacts = SliceSink::new(&mut slots);
    let (ball, mut count) = (Ball::new([1.0, 0.2, 0.0], 0.3), Count(0));
    let mut query = pose.query(&mut workspace).cached(&mut cache);
    if query.contacts(ball, &mut contacts)? == Coverage::Truncated {
        query.contacts(Cuboid::new([1.0, 0.0, 0.0], [0.5; 3]), &mut count)?;
    }
    count.0 += usize::from(query.intersects(ball)?);
    count.0 += usize::from(
        query
            .project_point([2.0, 0.0, 0.0], f64::INFINITY)?
            .is_some(),
    );
    let rays = [Ray::new([3.0, 0.0, 0.0], [-1.0, 0.0, 0.0]); 2];
    query.cast_ray_all(&rays[0], &mut count)?;
    query.cast_rays_all(&rays, &mut count)?;
    let mut exact = [0; 1 << 15];
    let mut refined = RefinedPose::in_bytes(&mut exact);
    refined.prepare(&pose)?;
    let mut query = pose.query(&mut workspace).refined(&refined);
    count.0 += usize::from(query.cast_ray(&rays[0])?.is_some());
    let mut kept = [0; CACHE.bytes()];
    let mut by_itself = StepCache::in_bytes(&mut kept, CACHE)?.refining(refined);
    by_itself.start(&pose);
    let mut query = pose.query(&mut workspace).cached(&mut by_itself);
    query.intersects_rays(&[rays[0]; 100], &mut [false; 100])?;
    count.0 += usize::from(by_itself.is_refined());
    let mut slots = [Proxy::EMPTY; 8];
    let mut proxies = SliceSink::new(&mut slots);
    let mut query = pose.query(&mut workspace).max_level(0, &mut proxies);
    query.contacts(ball, &mut count)?;
    let mut query = pose.query(&mut workspace);
    query.level_spheres(0, ball, &mut count)?;
    let mut query = query.max_visits(5);
    query.contacts(ball, &mut count)?;
    query.project_point([2.0, 0.0, 0.0], f64::INFINITY)?;
    studies::next_step(&mut cache, &pose);
    let mut query = studies::follow(pose.query(&mut workspace), &mut cache, &pose);
    query.contacts(ball, &mut count)?;
    let spheres = [pose.bounding_sphere()?; 2];
    broad::pairs(&spheres, 0.0, &mut workspace, &mut count)?;
    Ok(count.0 + contacts.items().len())
}

/// Queries of two meshes: with a front, with caches, distances, manifolds.
fn two(asset: &Asset<'_>) -> Result<usize, QueryError> {
    let (mut numbers, mut memory) = ([[0.0; 16]; 2], [0; 32768]);
    let (mut leaves, mut kept) = ([0; 16 * 64], [[0; CACHE.bytes()]; 2]);
    let [numbers1, numbers2] = &mut numbers;
    let beside = Transform {
        translation: [1.9, 0.0, 0.0],
        ..Transform::IDENTITY
    };
    let (Ok(first), Ok(second)) = (
        asset.pose(&[0.2, -0.1, 0.3], Transform::IDENTITY, numbers1),
        asset.pose(&[0.0; 3], beside, numbers2),
    ) else {
        return Ok(0);
    };
    let first = first.moving(&Motion::new(&first))?;
    let second = second.moving(&Motion::new(&second))?;
    let mut workspace = Workspace::in_bytes(&mut memory);
    let mut front = PairFront::in_bytes(&mut leaves);
    let mut count = Count(0);
    let mut query = first.against(&second, &mut workspace).front(&mut front);
    query.triangle_pairs(0.0, &mut count)?;
    query.contacts(0.0, &mut count)?;
    let mut query = first.against(&second, &mut workspace);
    query.level_spheres([0, 1], 0.0, 0.1, &mut count)?;
    query.level_triangles(0, 0.0, 0.1, &mut count)?;
    let [kept1, kept2] = &mut kept;
    let mut cache1 = StepCache::in_bytes(kept1, CACHE)?;
    let mut cache2 = StepCache::in_bytes(kept2, CACHE)?;
    cache1.start(&first);
    cache2.start(&second);
    let query = first.against(&second, &mut workspace);
    let mut query = query.cached(&mut cache1, &mut cache2);
    count.0 += usize::from(query.closest_points(f64::INFINITY)?.is_some());
    query.contact_manifolds(0.0, &mut count)?;
    let mut query = first.against(&second, &mut workspace).max_visits(20);
    query.closest_points(f64::INFINITY)?;
    Ok(count.0)
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {}
}
