//! The few calls to faer's sparse Cholesky, all of them sequential so that bytes repeat.

use crate::elastic::assemble::system::Pattern;
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::perm::PermRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};

impl Pattern {
    fn size(&self) -> usize {
        self.columns.len() - 1
    }

    fn view(&self) -> SymbolicSparseColMatRef<'_, usize> {
        SymbolicSparseColMatRef::new_checked(
            self.size(),
            self.size(),
            &self.columns,
            None,
            &self.rows,
        )
    }
}

/// Why a factorisation did not come about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FactorError {
    /// No memory, or sizes beyond the index type.
    Memory,
    /// A pivot was zero or had the wrong sign.
    Pivot,
}

/// Where the nonzeros of the factor will be.
#[derive(Debug)]
pub(crate) struct Symbolic {
    inner: SymbolicCholesky<usize>,
}

impl Symbolic {
    /// Analyses a pattern whose rows are already in order of elimination.
    pub(crate) fn new(pattern: &Pattern) -> Result<Self, FactorError> {
        // With `Identity` faer expects the upper triangle here and the lower one later.
        let identity: Vec<usize> = (0..pattern.size()).collect();
        let order = PermRef::new_checked(&identity, &identity, pattern.size());
        let params = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let inner = factorize_symbolic_cholesky(
            pattern.view(),
            Side::Lower,
            SymmetricOrdering::Custom(order),
            params,
        )
        .map_err(|_| FactorError::Memory)?;
        Ok(Self { inner })
    }

    /// Memory of the factor alone.
    pub(crate) fn factor_bytes(&self) -> u64 {
        8 * self.inner.len_val() as u64
    }

    /// LLᵀ of a positive definite matrix with the analysed pattern.
    pub(crate) fn factorize(
        &self,
        pattern: &Pattern,
        values: &[f64],
    ) -> Result<Factor<'_>, FactorError> {
        let mut factor = zeros(self.inner.len_val())?;
        let inner = &self.inner;
        let mut memory =
            buffer(inner.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default()))?;
        inner
            .factorize_numeric_llt(
                &mut factor,
                SparseColMatRef::new(pattern.view(), values),
                Side::Lower,
                LltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut memory),
                Default::default(),
            )
            .map_err(|_| FactorError::Pivot)?;
        Ok(Factor {
            symbolic: &self.inner,
            values: factor,
        })
    }

    /// Number of negative eigenvalues, by Sylvester's law of inertia from the pivots of LDLᵀ.
    pub(crate) fn negative_count(
        &self,
        pattern: &Pattern,
        values: &[f64],
    ) -> Result<usize, FactorError> {
        let mut factor = zeros(self.inner.len_val())?;
        let inner = &self.inner;
        let mut memory =
            buffer(inner.factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Default::default()))?;
        inner
            .factorize_numeric_ldlt(
                &mut factor,
                SparseColMatRef::new(pattern.view(), values),
                Side::Lower,
                LdltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut memory),
                Default::default(),
            )
            .map_err(|_| FactorError::Pivot)?;
        let SymbolicCholeskyRaw::Supernodal(parts) = self.inner.raw() else {
            return Err(FactorError::Pivot);
        };
        let mut negative = 0;
        for s in 0..parts.n_supernodes() {
            let width = parts.supernode_end()[s] - parts.supernode_begin()[s];
            let height = width + parts.supernode(s).pattern().len();
            let start = parts.col_ptr_for_val()[s];
            for d in (0..width).map(|j| factor[start + j * height + j]) {
                if !d.is_finite() {
                    return Err(FactorError::Pivot);
                }
                negative += usize::from(d < 0.0);
            }
        }
        Ok(negative)
    }
}

/// A factor that solves.
#[derive(Debug)]
pub(crate) struct Factor<'a> {
    symbolic: &'a SymbolicCholesky<usize>,
    values: Vec<f64>,
}

impl Factor<'_> {
    /// Replaces each column of `rhs` with the solution.
    pub(crate) fn solve(&self, rhs: MatMut<'_, f64>) -> Result<(), FactorError> {
        let symbolic = self.symbolic;
        let mut memory = buffer(symbolic.solve_in_place_scratch::<f64>(rhs.ncols(), Par::Seq))?;
        LltRef::new(symbolic, &self.values).solve_in_place_with_conj(
            Conj::No,
            rhs,
            Par::Seq,
            MemStack::new(&mut memory),
        );
        Ok(())
    }
}

fn buffer(needed: StackReq) -> Result<MemBuffer, FactorError> {
    MemBuffer::try_new(needed).map_err(|_| FactorError::Memory)
}

fn zeros(n: usize) -> Result<Vec<f64>, FactorError> {
    let mut values = Vec::new();
    values
        .try_reserve_exact(n)
        .map_err(|_| FactorError::Memory)?;
    values.resize(n, 0.0);
    Ok(values)
}
