//! Mutations of JSON as a tree: values of other types, keys that go or come, elements many times,
//! parts moved elsewhere, deep nesting.

use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use serde_json::{Map, Value, json};

use super::text::some_index;

/// Changes one thing; `other` is another file of the format.
pub(super) fn change(value: &mut Value, other: &Value, rng: &mut Pcg64Mcg) {
    let part = match rng.random_range(0..2) {
        0 => some(value, rng).clone(),
        _ => some(other, rng).clone(),
    };
    let place = some_mut(value, rng);
    match rng.random_range(0..10) {
        0..3 => *place = hostile(rng),
        3 => step(place, rng),
        4 => *place = part,
        5..7 => match place {
            Value::Object(fields) => {
                let keys: Vec<String> = fields.keys().cloned().collect();
                if let Some(k) = some_index(keys.len(), rng) {
                    fields.remove(&keys[k]);
                }
            }
            Value::Array(list) => {
                if let Some(k) = some_index(list.len(), rng) {
                    list.remove(k);
                }
            }
            other => *other = Value::Null,
        },
        7 | 8 => match place {
            Value::Object(fields) => {
                let keys: Vec<String> = fields.keys().cloned().collect();
                let Some(k) = some_index(keys.len(), rng) else {
                    return;
                };
                let moved = fields.remove(&keys[k]).unwrap_or_default();
                let name = [
                    "",
                    "nodes",
                    "x\u{1b}[31m\n",
                    "count",
                    "POSITION",
                    "instance",
                ];
                fields.insert(name[rng.random_range(0..name.len())].into(), moved);
            }
            Value::Array(list) => {
                let copies = [1, 1, 3, 40, 1000][rng.random_range(0..5)];
                if let Some(k) = some_index(list.len(), rng) {
                    let element = list[k].clone();
                    let size = element.to_string().len();
                    let copies = copies.min((1 << 16) / size.max(1));
                    list.splice(k..k, std::iter::repeat_n(element, copies));
                }
            }
            other => *other = part,
        },
        _ => {
            if let Value::Array(list) = place {
                let (Some(a), Some(b)) = (some_index(list.len(), rng), some_index(list.len(), rng))
                else {
                    return;
                };
                list.swap(a, b);
            } else {
                *place = json!([place.clone(), part]);
            }
        }
    }
}

/// A random part: steps down from the root stop anywhere.
fn some<'v>(mut value: &'v Value, rng: &mut Pcg64Mcg) -> &'v Value {
    while rng.random_range(0..6) > 0 {
        let next = match value {
            Value::Array(list) => some_index(list.len(), rng).map(|k| &list[k]),
            Value::Object(fields) => {
                some_index(fields.len(), rng).and_then(|k| fields.values().nth(k))
            }
            _ => None,
        };
        let Some(next) = next else { break };
        value = next;
    }
    value
}

fn some_mut<'v>(mut value: &'v mut Value, rng: &mut Pcg64Mcg) -> &'v mut Value {
    while rng.random_range(0..6) > 0 {
        let count = match value {
            Value::Array(list) => list.len(),
            Value::Object(fields) => fields.len(),
            _ => 0,
        };
        let Some(k) = some_index(count, rng) else {
            break;
        };
        value = match value {
            Value::Array(list) => &mut list[k],
            Value::Object(fields) => match fields.values_mut().nth(k) {
                Some(next) => next,
                None => unreachable!("counted"),
            },
            other => return other,
        };
    }
    value
}

/// A neighbour, a multiple, the negative of a number; of a list, one element more or less.
fn step(value: &mut Value, rng: &mut Pcg64Mcg) {
    match value {
        Value::Number(number) => {
            let x = number.as_f64().unwrap_or(0.0);
            *value = match (number.as_i64(), rng.random_range(0..5)) {
                (Some(n), 0) => json!(n.saturating_add(1)),
                (Some(n), 1) => json!(n.saturating_sub(1)),
                (Some(n), 2) => json!(n.saturating_mul(2)),
                (_, 3) => json!(-x),
                _ => json!(x * 1.5),
            };
        }
        Value::Array(list) => {
            list.pop();
        }
        Value::String(text) => {
            let keep = text.chars().count() / 2;
            *text = text.chars().take(keep).collect();
        }
        _ => {}
    }
}

/// A value that is seldom right.
fn hostile(rng: &mut Pcg64Mcg) -> Value {
    match rng.random_range(0..24) {
        0 => Value::Null,
        1 => json!(true),
        2 => json!(-1),
        3 => json!(0),
        4 => json!(1),
        5 => json!(0.5),
        6 => json!(1e39),
        7 => json!(1e308),
        8 => json!(5e-324),
        9 => json!(-1e20),
        10 => json!(u32::MAX),
        11 => json!(1_u64 << 32),
        12 => json!(u64::MAX),
        13 => json!(i64::MIN),
        14 => json!(100_000_000),
        15 => json!(""),
        16 => json!("\u{1b}[31mred\u{7}\nnext: line"),
        17 => json!("x".repeat(5000)),
        18 => json!([]),
        19 => Value::Object(Map::new()),
        20 => json!(vec![0; 3000]),
        21 => json!(vec![Value::Object(Map::new()); 300]),
        22 => json!("../../../../etc/passwd"),
        _ => {
            let depth = [3, 100, 127, 140][rng.random_range(0..4)];
            (0..depth).fold(json!(1), |inner, k| match k % 2 {
                0 => json!([inner]),
                _ => json!({ "a": inner }),
            })
        }
    }
}
