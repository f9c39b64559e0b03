//! Mass properties: numbers that some body can have (SPEC 7.10).

use bdtree_format::{
    MASS_TOLERANCE, MassRecord, ModeMomentum, ModeRecord, SectionKind, mass_source,
};
use core::mem::{offset_of, size_of};
use core::ops::ControlFlow;

use super::Report;
use crate::error::Datum;
use crate::math::second_moment_pivot;
use crate::view::Asset;

const FINITE: &str = "SPEC 7.10: numbers of MASS and MMOM are finite";

impl Asset<'_> {
    pub(super) fn mass_numbers(&self, report: Report<'_>) -> ControlFlow<()> {
        let Some(mass) = self.mass else {
            return ControlFlow::Continue(());
        };
        self.mass_record(mass, report)?;
        for (j, momentum) in self.momenta.iter().enumerate() {
            let numbers = (momentum.linear.iter()).chain(&momentum.angular);
            for (k, x) in numbers.enumerate() {
                let byte = j * size_of::<ModeMomentum>() + k * size_of::<f64>();
                let rule = self.at(SectionKind::MODE_MOMENTA, byte).rule(FINITE);
                rule.tell(report, x.get().is_finite(), "a finite number", x.get())?;
            }
            let known = self.modes.get(j).map_or(-1.0, modal_mass);
            let byte = j * size_of::<ModeMomentum>();
            self.at(SectionKind::MODE_MOMENTA, byte)
                .rule("SPEC 7.10: modes with momenta have modal masses")
                .tell(report, known != -1.0, "a modal mass", known)?;
        }
        ControlFlow::Continue(())
    }

    fn mass_record(&self, mass: &MassRecord, report: Report<'_>) -> ControlFlow<()> {
        let at = |offset: usize| self.at(SectionKind::MASS_PROPERTIES, offset);
        // All numbers stand before the source, eight bytes each.
        let mut finite = true;
        let positive = [
            (offset_of!(MassRecord, mass_kg), mass.mass_kg.get()),
            (
                offset_of!(MassRecord, density_kg_m3),
                mass.density_kg_m3.get(),
            ),
            (offset_of!(MassRecord, scale_m), mass.scale_m.get()),
            (offset_of!(MassRecord, volume), mass.volume.get()),
        ];
        let list = |start: usize, numbers: &'_ [zerocopy::little_endian::F64], k: usize| {
            (numbers.get(k)).map(|x| (start + k * size_of::<f64>(), x.get()))
        };
        let center = offset_of!(MassRecord, center_of_mass);
        let inertia = offset_of!(MassRecord, inertia);
        let others = (0..3)
            .filter_map(|k| list(center, &mass.center_of_mass, k))
            .chain((0..6).filter_map(|k| list(inertia, &mass.inertia, k)));
        for (offset, x) in positive.into_iter().chain(others) {
            finite &= x.is_finite();
            at(offset)
                .rule(FINITE)
                .tell(report, x.is_finite(), "a finite number", x)?;
        }
        let mut sound = finite;
        for (offset, x) in positive {
            sound &= x > 0.0;
            at(offset)
                .rule("SPEC 7.10: mass, density, scale and volume are positive")
                .tell(report, x > 0.0 || !x.is_finite(), "a positive number", x)?;
        }
        let source = mass.source.get();
        at(offset_of!(MassRecord, source))
            .rule("SPEC 7.10: a mass is that of a surface (1), a lattice (2) or elements (3)")
            .tell(
                report,
                (mass_source::SURFACE..=mass_source::ELEMENTS).contains(&source),
                Datum::Within(mass_source::SURFACE.into(), mass_source::ELEMENTS.into()),
                source,
            )?;
        let reserved = mass.reserved.iter().position(|b| *b != 0);
        if let Some(k) = reserved {
            let place = at(offset_of!(MassRecord, reserved) + k);
            let rule = place.rule("SPEC 7.10: reserved bytes of MASS are zero");
            report(rule.broken(0_u32, mass.reserved[k]))?;
        }
        if !sound {
            // What follows would say the same of the same numbers.
            return ControlFlow::Continue(());
        }
        let scale = mass.scale_m.get();
        let of_volume = mass.density_kg_m3.get() * mass.volume.get() * (scale * scale * scale);
        let own = mass.mass_kg.get();
        at(offset_of!(MassRecord, mass_kg))
            .rule("SPEC 7.10: mass is density x volume x scale^3 within 1e-9")
            .tell(
                report,
                (own - of_volume).abs() <= MASS_TOLERANCE * own,
                of_volume,
                own,
            )?;
        let entries = mass.inertia.map(|x| x.get());
        let diagonal = entries[..3].iter().all(|x| *x > 0.0);
        let pivot = second_moment_pivot(entries, MASS_TOLERANCE);
        at(offset_of!(MassRecord, inertia))
            .rule(
                "SPEC 7.10: the inertia is that of a body: positive, no principal moment above the sum of the others",
            )
            .tell(report, diagonal && pivot > 0.0, "positive second moments", pivot)
    }
}

fn modal_mass(mode: &ModeRecord) -> f64 {
    mode.modal_mass_kg.get()
}
