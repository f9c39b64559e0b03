//! The system of a component of the lattice.

use crate::elastic::assemble::Source;
use crate::elastic::assemble::constraint::Constraint;
use crate::elastic::assemble::ordering::nested_dissection;
use crate::elastic::assemble::system::System;
use crate::elastic::element::NodeLists;
use crate::elastic::element::spline::Element;
use crate::elastic::lattice::Component;

impl System {
    /// Adds up the cells of a component and the springs at its held points. Functions follow
    /// lines, so their coefficients move as points at their centers do: those are the positions.
    pub(crate) fn of_lattice(
        component: &Component,
        element: &Element,
        constraints: &[Constraint],
    ) -> Result<Self, usize> {
        let mut cells = NodeLists::default();
        for cell in &component.cells {
            cells.push(*cell);
        }
        let source = Source {
            positions: component.nodes.iter().map(|n| n.map(f64::from)).collect(),
            order: nested_dissection(&component.nodes).order,
            elements: std::borrow::Cow::Owned(cells),
            constraints,
            ..Source::default()
        };
        Self::assemble(&source, |cell| {
            Some(element.matrices(&component.moments[cell]))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elastic::assemble::constraint::Anchor;
    use crate::elastic::element::moments::full_cell;
    use crate::elastic::solve::factor::Symbolic;
    use faer::Mat;

    /// A row of full cells.
    fn bar(cells: i32) -> Component {
        let mut c = Component::default();
        for x in -1..=cells {
            for n in 0..9 {
                c.nodes.push([x, n % 3 - 1, n / 3 - 1]);
            }
        }
        for x in 0..cells as u32 {
            let at = |i: u32| 9 * (x + i % 3) + i / 3;
            c.cells.push(std::array::from_fn(|i| at(i as u32)));
            c.moments.push(full_cell());
        }
        c
    }

    #[test]
    fn order_is_a_permutation_and_solves_match_products() {
        let component = bar(30);
        let constraints: Vec<Constraint> = (0..9)
            .map(|n| Constraint {
                anchor: Anchor {
                    component: 0,
                    nodes: component.cells[0],
                    weights: std::array::from_fn(|i| f64::from(i == n)),
                },
                axes: [true; 3],
                share: 1.0,
            })
            .collect();
        let system =
            System::of_lattice(&component, &Element::new(0.3), &constraints).expect("a system");
        let mut seen = system.place.clone();
        seen.sort_unstable();
        assert!(seen.iter().enumerate().all(|(i, &p)| i == p as usize));
        let pattern = system.pattern();
        let symbolic = Symbolic::new(&pattern).expect("memory");
        let factor = symbolic
            .factorize(&pattern, &system.values(0.0, &[]))
            .expect("positive definite");
        let x = Mat::from_fn(system.size(), 2, |i, j| ((i * 7 + j * 3) % 11) as f64 - 5.0);
        let mut y = system.apply_stiffness(x.as_ref());
        factor.solve(y.as_mut()).expect("memory");
        for i in 0..system.size() {
            assert!((y[(i, 0)] - x[(i, 0)]).abs() < 1e-6);
        }
    }

    #[test]
    fn negative_pivots_count_eigenvalues() {
        let component = bar(12);
        let system = System::of_lattice(&component, &Element::new(0.3), &[]).expect("a system");
        let modes =
            crate::elastic::solve::tests::dense::all_modes(&system, 6).expect("eigenvalues");
        let pattern = system.pattern();
        let symbolic = Symbolic::new(&pattern).expect("memory");
        for n in 1..80 {
            if modes.values[n] < 1.001 * modes.values[n - 1] {
                continue; // one of the square section's pairs
            }
            let between = 0.5 * (modes.values[n - 1] + modes.values[n]);
            let count = symbolic.negative_count(&pattern, &system.values(between, &[]));
            assert_eq!(count, Ok(n + 6));
        }
    }
}
