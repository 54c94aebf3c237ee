// Sizes that both sides know.

// Voxels along the edge of a block, brick and group of bricks.
const BLOCK_VOXELS: u32 = 4u;
const BRICK_VOXELS: u32 = 8u;
const GROUP_VOXELS: u32 = 32u;
// Words of a group's record in `world_grid`: mask low, mask high, first entry, unused.
const GROUP_WORDS: u32 = 4u;
// Allocation unit of a brick in `world_bricks`, in words (32 bytes).
const PAGE_WORDS: u32 = 8u;
// Words of a block's record in a brick.
const BLOCK_WORDS: u32 = 3u;
// Bricks voxelised by one dispatch: 32 x 1000 workgroups stay below the 65535 that every device offers.
const BATCH_BRICKS: u32 = 32u;
// A brick and one voxel around it.
const APRON_VOXELS: u32 = 10u;
const APRON_COUNT: u32 = 1000u;
// Words of a bit for each of them.
const REACH_WORDS: u32 = (APRON_COUNT + 31u) / 32u;
// Places for requests for light in `counters`, two words each, and where they begin.
const REQUESTS: u32 = 256u;
const REQUESTS_WORD: u32 = 4u;
const COUNTER_WORDS: u32 = REQUESTS_WORD + 2u * REQUESTS;
// Words of a voxel's six faces between `voxelize` and `face_resolve`.
const RECORD_WORDS: u32 = 18u;
// Surfaces on a voxel's border are moved this far into the solid (voxels): accuracy rule "ties go into the solid".
const TIE_SHIFT: f32 = 0.002;
// Set in a triangle's material word: both sides are surface.
const TWO_SIDED: u32 = 0x80000000u;
// Flag in a triangle's material word: its material lets light through.
const TRANSLUCENT: u32 = 0x40000000u;
const MATERIAL_MASK: u32 = 0x3fffffffu;
// `Material.texture` without a texture.
const NO_TEXTURE: u32 = 0xffffffffu;
const NONE: u32 = 0xffffffffu;
// Light of a face that has never been lit: black, and no word that an encoder writes.
const UNLIT: u32 = 0xf8000000u;
// Kinds of sky.
const SKY_CONSTANT: u32 = 0u;
const SKY_GRADIENT: u32 = 1u;
const SKY_IMAGE: u32 = 2u;
// Texels along the edge of its map: 16 KiB, which every device takes as a uniform buffer.
const SKY_EDGE: u32 = 64u;
// Nearer than this (voxels) each pixel looks for itself: probes stand too far apart for contacts.
const NEAR_VOXELS: f32 = 2.0;
// Rays of a screen probe.
const PROBE_RAYS: u32 = 64u;
// Words of a probe's lobes: 64 halves and a normal.
const LOBE_WORDS: u32 = 34u;
// What a probe's tile has: none; one of the last frame's; a new one; a new one in its turn.
const PROBE_NONE: u32 = 0u;
const PROBE_CARRIED: u32 = 1u;
const PROBE_NEW: u32 = 2u;
const PROBE_IN_TURN: u32 = 3u;
// Layers of screen probes.
const PROBE_LAYERS: u32 = 2u;
// How much a probe needs to look: no old one has come to its tile, or to that of its second layer; it is its turn; its pixels
// have not been seen for long.
const PROBE_NEEDS: u32 = 4u;
// Places in the order in which those of the same need may look.
const PROBE_RANKS: u32 = 256u;
// Halvings of the probes' mips.
const PROBE_MIPS: u32 = 3u;
// Bits of a probe's index in what it claims a tile with.
const PROBE_MASK: u32 = 0xfffffu;
// What a debug view shows.
const DEBUG_BRICKS: u32 = 1u;
const DEBUG_ALBEDO: u32 = 2u;
const DEBUG_NORMALS: u32 = 3u;
const DEBUG_RADIANCE: u32 = 4u;
const DEBUG_STEPS: u32 = 5u;
const DEBUG_HISTORY: u32 = 6u;
const DEBUG_PROBES: u32 = 7u;
const DEBUG_IRRADIANCE: u32 = 8u;
const DEBUG_PROBE_RADIANCE: u32 = 9u;
const DEBUG_FALLBACK: u32 = 10u;
// Kinds of light.
const LIGHT_DIRECTIONAL: u32 = 0u;
const LIGHT_POINT: u32 = 1u;
const LIGHT_SPOT: u32 = 2u;
// From here on, lights with an extent.
const LIGHT_SPHERE: u32 = 3u;
const LIGHT_RECTANGLE: u32 = 4u;
const LIGHT_TWO_SIDED_RECTANGLE: u32 = 5u;
