//! Meshes in the host's buffers, on their way to the CPU, where the lists of bricks are made.
//!
//! They come in the order in which they were handed over, a bounded number of bytes a frame: each frame copies pieces of
//! them into a buffer of its slot, and when the slot comes round again the pieces are read.

use super::{FrameScope, World};
use crate::error::Result;
use crate::scene::{Array, BufferMeshDesc, MeshDesc, MeshUpdate, Scene};
use ash::vk;
use rustc_hash::FxHashSet;
use std::collections::VecDeque;
use std::ops::Range;

/// Pieces that a frame copies at most.
const PIECES_MAX: usize = 4096;

/// A mesh of which something is still missing.
struct Pending {
    /// Grows from mesh to mesh.
    serial: u64,
    desc: BufferMeshDesc,
    arrays: [Array; 3],
    /// Elements of each array that have been asked for.
    asked: [u32; 3],
    positions: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    indices: Vec<u32>,
}

impl Pending {
    fn is_asked(&self) -> bool {
        self.arrays.iter().zip(self.asked).all(|(array, asked)| asked == array.count)
    }

    fn is_complete(&self) -> bool {
        let have = [self.positions.len(), self.uvs.len(), self.indices.len()];
        self.arrays.iter().zip(have).all(|(array, have)| have == array.count as usize)
    }

    /// Reads the next elements of an array.
    fn read(&mut self, array: usize, bytes: &[u8]) {
        let (desc, stride) = (&self.desc, self.arrays[array].layout.stride);
        match (array, desc.uvs) {
            (0, _) => self.positions.extend(desc.positions.format.decode(bytes, stride)),
            (1, Some(uvs)) => self.uvs.extend(uvs.format.decode(bytes, stride)),
            _ => self.indices.extend(desc.indices.index_type.decode(bytes)),
        }
    }

    fn desc(&self) -> MeshDesc<'_> {
        MeshDesc { id: self.desc.id, positions: &self.positions, uvs: &self.uvs, indices: &self.indices }
    }
}

/// A run of an array's elements in a slot's buffer.
struct Piece {
    serial: u64,
    array: usize,
    count: u32,
    place: Range<usize>,
}

/// What a frame is to bring.
#[derive(Default)]
struct Plan {
    pieces: Vec<Piece>,
    /// Of each piece: out of which buffer, and into which part of the slot's.
    copies: Vec<(vk::Buffer, vk::BufferCopy)>,
    /// Of the slot's buffer.
    bytes: u64,
}

/// The meshes that are waited for, and what each frame in flight will bring of them.
pub struct Readback {
    queue: VecDeque<Pending>,
    flights: Vec<Vec<Piece>>,
    next: u64,
}

impl Readback {
    pub fn new(frames_in_flight: usize) -> Self {
        Self { queue: VecDeque::new(), flights: (0..frames_in_flight).map(|_| Vec::new()).collect(), next: 0 }
    }

    /// Takes in a checked batch: what it removes or replaces is no longer waited for.
    pub fn update(&mut self, update: &MeshUpdate) -> Result<()> {
        let given = update.meshes.iter().map(|m| m.id).chain(update.buffer_meshes.iter().map(|m| m.id));
        let dropped: FxHashSet<u64> = update.removed_meshes.iter().copied().chain(given).collect();
        if !dropped.is_empty() {
            self.queue.retain(|pending| !dropped.contains(&pending.desc.id));
        }
        for desc in update.buffer_meshes {
            let (positions, uvs, indices) = Default::default();
            let (arrays, serial) = (desc.arrays()?, self.next);
            self.queue.push_back(Pending { serial, desc: *desc, arrays, asked: [0; 3], positions, uvs, indices });
            self.next += 1;
        }
        Ok(())
    }

    /// Meshes that are waited for.
    pub fn pending(&self) -> u32 {
        self.queue.len() as u32
    }

    /// The next pieces that `room` bytes hold.
    fn plan(&self, room: u64) -> Plan {
        let mut plan = Plan::default();
        // Those before have been asked for as a whole.
        let first = self.queue.partition_point(Pending::is_asked);
        for pending in self.queue.range(first..) {
            for (array, (Array { buffer, offset, layout, count, .. }, asked)) in
                pending.arrays.into_iter().zip(pending.asked).enumerate()
            {
                let left = count - asked;
                if left == 0 {
                    continue;
                }
                let start = plan.bytes.next_multiple_of(4);
                let fitting = layout.fitting(room.saturating_sub(start)).min(left);
                if fitting == 0 || plan.pieces.len() == PIECES_MAX {
                    return plan;
                }
                let size = layout.span(fitting);
                plan.bytes = start + size;
                let place = start as usize..plan.bytes as usize;
                plan.pieces.push(Piece { serial: pending.serial, array, count: fitting, place });
                let src_offset = offset + u64::from(asked) * u64::from(layout.stride);
                plan.copies.push((buffer, vk::BufferCopy { src_offset, dst_offset: start, size }));
                if fitting < left {
                    return plan;
                }
            }
        }
        plan
    }

    /// The slot's frame brings them.
    fn ask(&mut self, index: usize, pieces: Vec<Piece>) {
        for Piece { serial, array, count, .. } in &pieces {
            if let Some(pending) = self.find(*serial) {
                pending.asked[*array] += count;
            }
        }
        self.flights[index] = pieces;
    }

    /// None: it has been removed or replaced.
    fn find(&mut self, serial: u64) -> Option<&mut Pending> {
        let at = self.queue.binary_search_by_key(&serial, |pending| pending.serial).ok()?;
        self.queue.get_mut(at)
    }

    /// Takes in what the slot's last frame brought. Returns the meshes of which nothing is missing any more.
    fn arrive(&mut self, index: usize, bytes: &[u8]) -> Vec<Pending> {
        for Piece { serial, array, place, .. } in std::mem::take(&mut self.flights[index]) {
            if let Some(pending) = self.find(serial) {
                pending.read(array, &bytes[place]);
            }
        }
        let complete = self.queue.iter().take_while(|pending| pending.is_complete()).count();
        self.queue.drain(..complete).collect()
    }
}

impl World {
    /// Registers the meshes whose last piece the slot's last frame brought. One that cannot be used counts as empty.
    pub(super) fn take_in_meshes(&mut self, index: usize, scene: &mut Scene) {
        let complete = self.readback.arrive(index, self.memory.readback(index));
        if complete.is_empty() {
            return;
        }
        let mut meshes: Vec<MeshDesc> = complete.iter().map(Pending::desc).collect();
        for mesh in &mut meshes {
            if let Err(error) = scene.check(&MeshUpdate { meshes: &[*mesh], ..MeshUpdate::default() }) {
                self.warnings.push(format!("a mesh in the host's buffers counts as empty: {error}"));
                *mesh = MeshDesc { positions: &[], uvs: &[], indices: &[], ..*mesh };
            }
        }
        let changed = scene.apply(&MeshUpdate { meshes: &meshes, ..MeshUpdate::default() });
        self.instances_changed(&changed, scene);
    }

    /// Has this frame copy what it may of the meshes that are waited for; gives back the slot's buffer where none is.
    pub(super) fn ask_for_meshes(&mut self, scope: &mut FrameScope) -> Result<()> {
        let room = self.memory.readback_room(scope, self.spare);
        let Plan { pieces, copies, bytes } = self.readback.plan(room);
        if pieces.is_empty() {
            self.memory.release_readback(scope);
            return Ok(());
        }
        self.memory.read_back(scope, [bytes, room], &copies)?;
        self.readback.ask(scope.index, pieces);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{BufferAddress, IndexBuffer, IndexType, VertexBuffer, VertexFormat};
    use crate::twin::random::Random;
    use ash::vk::Handle;
    use half::f16;
    use std::collections::BTreeMap;

    /// What the host has said of a mesh, as the CPU would have it.
    type Truth = (Vec<[f32; 3]>, Vec<[f32; 2]>, Vec<u32>);

    /// The host's buffers by handle.
    #[derive(Default)]
    struct Host(BTreeMap<u64, Vec<u8>>);

    impl Host {
        /// A new buffer with an array of elements in it, and what an array's stride is.
        fn add(&mut self, elements: &[Vec<u8>], align: u64, random: &mut Random) -> (BufferAddress, u32) {
            let offset = align * u64::from(random.below(5));
            let gap = align * u64::from(random.below(4));
            let mut bytes = vec![0xcd; offset as usize];
            for element in elements {
                bytes.extend_from_slice(element);
                bytes.resize(bytes.len() + gap as usize, 0xcd);
            }
            let handle = self.0.len() as u64 + 1;
            self.0.insert(handle, bytes);
            // SAFETY: never seen by a device.
            let address = unsafe { BufferAddress::new(vk::Buffer::from_raw(handle), offset) };
            (address, (elements[0].len() as u64 + gap) as u32)
        }

        fn vertices<const N: usize>(&mut self, values: &[[f32; N]], random: &mut Random) -> VertexBuffer {
            let half = |v: &f32| f16::from_f32(*v).to_ne_bytes();
            let (format, elements): (_, Vec<Vec<u8>>) = if random.chance(0.5) {
                (VertexFormat::Float16, values.iter().map(|v| v.iter().flat_map(half).collect()).collect())
            } else {
                (VertexFormat::Float32, values.iter().map(|v| bytemuck::cast_slice(v).to_vec()).collect())
            };
            let align = if format == VertexFormat::Float16 { 2 } else { 4 };
            let (address, stride) = self.add(&elements, align, random);
            VertexBuffer { address, stride, format }
        }

        /// A mesh of up to 200 vertices, whose numbers halves can hold.
        fn mesh(&mut self, id: u64, random: &mut Random) -> (BufferMeshDesc, Truth) {
            let mut number = || random.below(2000) as f32 / 8.0 - 100.0;
            let positions: Vec<[f32; 3]> = (0..200).map(|_| std::array::from_fn(|_| number())).collect();
            let positions = positions[..1 + random.below(200) as usize].to_vec();
            let uvs: Vec<[f32; 2]> = positions.iter().map(|[x, _, z]| [*z, *x]).collect();
            let uvs = if random.chance(0.5) { uvs } else { Vec::new() };
            let count = 3 * (1 + random.below(100));
            let indices: Vec<u32> = (0..count).map(|_| random.below(positions.len() as u32)).collect();
            let index_type = if random.chance(0.5) { IndexType::Uint16 } else { IndexType::Uint32 };
            let packed: Vec<u8> =
                indices.iter().flat_map(|i| i.to_ne_bytes()[..index_type.layout().element as usize].to_vec()).collect();
            let desc = BufferMeshDesc {
                id,
                vertex_count: positions.len() as u32,
                index_count: count,
                positions: self.vertices(&positions, random),
                uvs: (!uvs.is_empty()).then(|| self.vertices(&uvs, random)),
                indices: IndexBuffer { address: self.add(&[packed], 4, random).0, index_type },
            };
            (desc, (positions, uvs, indices))
        }
    }

    /// Meshes come, are replaced and removed while frames of any size are in flight: each arrives whole, once, in order,
    /// and none of those that nobody waits for any more.
    #[test]
    fn whatever_the_rooms_meshes_arrive_as_they_were_given() {
        const SLOTS: usize = 3;
        let (mut random, mut host, mut readback) = (Random::new(5), Host::default(), Readback::new(SLOTS));
        let mut expected: Vec<(u64, Truth)> = Vec::new();
        let mut slots = vec![Vec::new(); SLOTS];
        let (mut arrived, mut dropped, mut frames) = (0, 0, 0);
        while frames < 4000 || readback.pending() > 0 {
            let id = u64::from(random.below(8));
            if frames < 4000 && random.chance(0.3) {
                let before = expected.len();
                expected.retain(|e| e.0 != id);
                dropped += before - expected.len();
                let (desc, truth) = host.mesh(id, &mut random);
                let none = MeshUpdate::default();
                let update = match random.below(4) {
                    0 => MeshUpdate { removed_meshes: &[id], ..none },
                    1 => MeshUpdate { meshes: &[MeshDesc { id, positions: &[], uvs: &[], indices: &[] }], ..none },
                    _ => {
                        expected.push((id, truth));
                        MeshUpdate { buffer_meshes: &[desc], ..none }
                    }
                };
                readback.update(&update).expect("valid meshes");
            }
            assert_eq!(readback.pending() as usize, expected.len());
            let index = frames % SLOTS;
            for mesh in readback.arrive(index, &slots[index]) {
                let (id, truth) = expected.remove(0);
                assert_eq!((mesh.desc.id, (mesh.positions, mesh.uvs, mesh.indices)), (id, truth), "frame {frames}");
                arrived += 1;
            }
            let room = [0, 3, 16, 100, 1000, 5000][random.below(6) as usize];
            let Plan { pieces, copies, bytes } = readback.plan(room);
            assert!(bytes <= room, "{bytes} of {room}");
            readback.ask(index, pieces);
            slots[index] = vec![0xab; bytes as usize];
            for (buffer, vk::BufferCopy { src_offset, dst_offset, size }) in copies {
                let [src, dst, size] = [src_offset, dst_offset, size].map(|v| v as usize);
                slots[index][dst..dst + size].copy_from_slice(&host.0[&buffer.as_raw()][src..src + size]);
            }
            frames += 1;
        }
        println!("{arrived} meshes arrived and {dropped} were dropped before they had, in {frames} frames");
        assert!(expected.is_empty() && arrived > 100 && dropped > 100);
    }
}
