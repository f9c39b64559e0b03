//! The solution against known modes, and the oracle of other tests.

mod bars;
pub(crate) mod dense;
