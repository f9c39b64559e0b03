//! Frame sequences: every format reads the same numbers, and says what is wrong where.

mod corpus;
mod read;
mod refused;
mod support;
mod times;
