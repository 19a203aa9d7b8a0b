//! Elementary functions from additions, multiplications and square roots alone. Those round alike on every machine;
//! the system's `sin` and `exp` do not, and the assets must come out the same, bit for bit, wherever they are made.

/// pi / 2 as a sum of two doubles, so that the reduction below loses nothing.
const HALF_PI: [f64; 2] = [std::f64::consts::FRAC_PI_2, 6.123_233_995_736_766e-17];

/// Sine. Good to 1e-12 for |x| < 1e6.
pub(crate) fn sin(x: f64) -> f64 {
    quarter_waves(x, 0)
}

/// Cosine. Good to 1e-12 for |x| < 1e6.
pub(crate) fn cos(x: f64) -> f64 {
    quarter_waves(x, 1)
}

fn quarter_waves(x: f64, shift: i64) -> f64 {
    let turns = (x / HALF_PI[0]).round();
    let r = (x - turns * HALF_PI[0]) - turns * HALF_PI[1];
    let quarter = (turns as i64 + shift).rem_euclid(4);
    // Taylor series on [-pi/4, pi/4]: sine from its first term, cosine from its zeroth.
    let series = |first: f64, start: f64| {
        let (mut sum, mut term, mut n) = (first, first, start);
        for _ in 0..9 {
            term *= -r * r / (n * (n + 1.0));
            n += 2.0;
            sum += term;
        }
        sum
    };
    let value = if quarter % 2 == 0 { series(r, 2.0) } else { series(1.0, 1.0) };
    if quarter >= 2 { -value } else { value }
}

/// e^x, 0 below the range of doubles.
pub(crate) fn exp(x: f64) -> f64 {
    if x < -700.0 {
        return 0.0;
    }
    let k = (x.min(700.0) / std::f64::consts::LN_2).round();
    let r = x.min(700.0) - k * std::f64::consts::LN_2;
    let (mut sum, mut term) = (1.0, 1.0);
    for n in 1..16 {
        term *= r / f64::from(n);
        sum += term;
    }
    sum * f64::from_bits(((k as i64 + 1023) as u64) << 52)
}

/// Natural logarithm of a positive normal number.
pub(crate) fn ln(x: f64) -> f64 {
    let bits = x.to_bits();
    let mut exponent = (bits >> 52) as i64 - 1023;
    let mut m = f64::from_bits((bits & ((1 << 52) - 1)) | (1023 << 52));
    if m > std::f64::consts::SQRT_2 {
        m *= 0.5;
        exponent += 1;
    }
    let s = (m - 1.0) / (m + 1.0);
    let (mut sum, mut power) = (0.0, s);
    for n in 0..14 {
        sum += power / f64::from(2 * n + 1);
        power *= s * s;
    }
    2.0 * sum + exponent as f64 * std::f64::consts::LN_2
}

/// x^y for x >= 0.
pub(crate) fn pow(x: f64, y: f64) -> f64 {
    if x <= 1e-300 { 0.0 } else { exp(y * ln(x)) }
}
