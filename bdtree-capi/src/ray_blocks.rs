//! Many rays of one call: the runtime casts a block of them at a time, so that rays of refined poses go on together and
//! what is copied stays in the nearest cache.

use bdtree_runtime::{Query, QueryError, Ray, Stats};

/// Rays of a block: with their hits 20 kB.
const BLOCK: usize = 128;

/// Casts rays, each with a number, and puts each one's answer with its number; adds what that took to `sum`.
/// `cast` asks for several at once, and `none` is any answer.
///
/// # Errors
/// Those of `cast`; answers of rays before the one that is refused are put.
#[inline(always)] // into the loop over the caller's rays
pub(crate) fn cast_in_blocks<'q, 'm, T: Copy>(
    query: &mut Query<'q, 'm>,
    sum: &mut Stats,
    mut rays: impl Iterator<Item = (usize, Ray)>,
    none: T,
    cast: impl Fn(&mut Query<'q, 'm>, &[Ray], &mut [T]) -> Result<(), QueryError>,
    mut put: impl FnMut(usize, T),
) -> Result<(), QueryError> {
    let mut numbers = [0; BLOCK];
    let mut block = [Ray::new([0.0; 3], [0.0; 3]); BLOCK];
    let mut answers = [none; BLOCK];
    loop {
        let mut count = 0;
        for ((number, slot), (index, ray)) in numbers.iter_mut().zip(&mut block).zip(&mut rays) {
            (*number, *slot) = (index, ray);
            count += 1;
        }
        if count == 0 {
            return Ok(());
        }
        let (numbers, block, answers) = (&numbers[..count], &block[..count], &mut answers[..count]);
        let found = cast(query, block, answers);
        add(sum, query.stats());
        if found.is_err() {
            // One of them is refused: again, one by one, up to that one.
            for (number, ray) in numbers.iter().zip(block) {
                let mut answer = [none];
                cast(query, std::slice::from_ref(ray), &mut answer)?;
                put(*number, answer[0]);
            }
            return found;
        }
        for (number, answer) in numbers.iter().zip(answers) {
            put(*number, *answer);
        }
    }
}

/// Adds what one query did to what several did.
pub(crate) fn add(sum: &mut Stats, of_one: Stats) {
    sum.nodes_visited += of_one.nodes_visited;
    sum.nodes_updated += of_one.nodes_updated;
}
