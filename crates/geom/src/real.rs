//! Transcendental functions with the same bits on every machine.
pub fn sin_cos(x: f32) -> (f32, f32) {
    libm::sincosf(x)
}
pub fn tan(x: f32) -> f32 {
    libm::tanf(x)
}
pub fn ln(x: f32) -> f32 {
    libm::logf(x)
}
pub fn atan2(y: f32, x: f32) -> f32 {
    libm::atan2f(y, x)
}
