//! Every rule that the runtime cites has an input that triggers it; the text names section, byte, rule, what was expected and what is there.

mod asked;
mod mass;
mod rules;
mod seen;
mod skin;
