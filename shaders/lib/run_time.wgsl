// `setting`, where a branch or the length of a loop depends on it alone. Software drivers (lavapipe 22) specialise a
// pipeline for the values of such uniforms in each dispatch anew, for tens of milliseconds, and keep what they made:
// `small`, any number below 2^31 that they do not know, keeps them from it, and changes nothing.
fn at_run_time(setting: u32, small: u32) -> u32 {
    return setting + (small >> 31u);
}
