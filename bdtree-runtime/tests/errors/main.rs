//! Every rule that the runtime cites has an input that triggers it; the text names section, byte, rule, what was expected and what is there.

mod asked;
mod deep;
mod edits;
mod mass;
mod open;
mod rules;
mod seen;
mod skin;
