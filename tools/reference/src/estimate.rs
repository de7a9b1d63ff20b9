//! How far a computed figure is from what an infinitely fine grid would give, from three grids (Richardson).

/// What three grids say together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The figure for an infinitely fine grid; the finest grid's where the three do not converge evenly.
    pub value: f64,
    /// Order p of an error that goes as h^p; `None` where the three do not converge evenly.
    pub order: Option<f64>,
    /// Estimated error of the finest grid's figure.
    pub error: f64,
}

/// Orders below this are taken for this one: a slower convergence cannot be told from none with three grids.
const ORDER_LEAST: f64 = 0.5;

/// From the figures of three grids, coarse to fine, each `ratio` times finer than the one before.
///
/// # Panics
/// If `ratio` is not above 1.
#[must_use]
pub fn richardson(figures: [f64; 3], ratio: f64) -> Estimate {
    assert!(ratio > 1.0, "ratio = {ratio}, allowed above 1");
    let [coarse, middle, fine] = figures;
    let (first, last) = (middle - coarse, fine - middle);
    let spread = first.abs().max(last.abs());
    if first * last <= 0.0 || last.abs() >= first.abs() {
        return Estimate { value: fine, order: None, error: spread };
    }
    let order = (first / last).ln() / ratio.ln();
    let rest = last / (ratio.powf(order.max(ORDER_LEAST)) - 1.0);
    Estimate { value: fine + rest, order: Some(order), error: rest.abs() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_known_order_is_found() {
        let at = |h: f64| 3.0 + 0.7 * h.powf(1.5);
        let found = richardson([at(0.4), at(0.2), at(0.1)], 2.0);
        assert!((found.value - 3.0).abs() < 1e-12 && (found.order.unwrap() - 1.5).abs() < 1e-12);
        assert!((found.error - (at(0.1) - 3.0)).abs() < 1e-12);
    }

    #[test]
    fn figures_that_do_not_settle_have_no_order() {
        assert_eq!(richardson([1.0, 1.2, 1.1], 2.0).order, None);
        assert!((richardson([1.0, 1.1, 1.3], 2.0).error - 0.2).abs() < 1e-12);
    }
}
