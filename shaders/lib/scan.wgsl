// Sums over the threads of a workgroup of 64.

var<workgroup> scan: array<vec2<u32>, 64>;

// Sum of what the threads before this one have; `scan[63]` is the sum of all, until the next call.
fn sum_below(thread: u32, value: vec2<u32>) -> vec2<u32> {
    workgroupBarrier();
    scan[thread] = value;
    workgroupBarrier();
    for (var reach = 1u; reach < 64u; reach <<= 1u) {
        var left = vec2<u32>(0u);
        if thread >= reach { left = scan[thread - reach]; }
        workgroupBarrier();
        scan[thread] += left;
        workgroupBarrier();
    }
    return scan[thread] - value;
}
