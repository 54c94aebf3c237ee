//! The frame as data: an ordered list of commands that `gpu` plays into the host's command buffer.

/// Workgroups of a dispatch.
#[derive(Clone, Debug, PartialEq)]
pub enum Groups {
    /// Known on the CPU.
    Direct([u32; 3]),
    /// Three words at the start of the named buffer.
    Indirect(&'static str),
}

/// A pass's push constants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Push {
    bytes: [u8; Self::MAX],
    count: u8,
}

impl Push {
    /// What every device takes.
    const MAX: usize = 128;

    fn new<P: bytemuck::Pod>(push: P) -> Self {
        let from = bytemuck::bytes_of(&push);
        let mut bytes = [0; Self::MAX];
        bytes[..from.len()].copy_from_slice(from);
        Self { bytes, count: from.len() as u8 }
    }

    /// As the shader reads them.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes[..usize::from(self.count)]
    }
}

/// One thing to record.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Fills a buffer with zeros.
    Clear(&'static str),
    /// Makes the copies between buffers that go by this name: what is kept of a buffer into the one that replaces it, or
    /// what the host's buffers hold into `readback`.
    Copy(&'static str),
    /// Runs a pass; its resources are found by the names in its shader.
    Dispatch {
        /// The pass.
        pass: &'static str,
        /// Its workgroups.
        groups: Groups,
        /// Its push constants.
        push: Push,
    },
}

/// A frame: what to record, in order, and the bytes that it reads.
#[derive(Default)]
pub struct Frame {
    /// In order.
    pub commands: Vec<Command>,
    /// All of the frame's small inputs.
    pub upload: Upload,
}

impl Frame {
    /// Empties it; its memory stays.
    pub fn clear(&mut self) {
        self.commands.clear();
        self.upload.bytes.clear();
        self.upload.pieces.clear();
    }

    /// Adds a pass; one without workgroups is not recorded at all.
    pub fn dispatch<P: bytemuck::Pod>(&mut self, pass: &'static str, groups: [u32; 3], push: P) {
        if groups.iter().all(|g| *g > 0) {
            let push = Push::new(push);
            self.commands.push(Command::Dispatch { pass, groups: Groups::Direct(groups), push });
        }
    }

    /// Adds a pass whose workgroups the GPU counted.
    pub fn dispatch_indirect<P: bytemuck::Pod>(&mut self, pass: &'static str, arguments: &'static str, push: P) {
        let push = Push::new(push);
        self.commands.push(Command::Dispatch { pass, groups: Groups::Indirect(arguments), push });
    }
}

/// Named pieces of one buffer, each aligned for any binding.
#[derive(Default)]
pub struct Upload {
    bytes: Vec<u8>,
    pieces: Vec<(&'static str, usize, usize)>,
}

impl Upload {
    const ALIGNMENT: usize = 256;

    /// Adds a piece; an empty one still gets room for a value, so that it can be bound.
    pub fn push<T: bytemuck::Pod>(&mut self, name: &'static str, values: &[T]) {
        let start = self.bytes.len().next_multiple_of(Self::ALIGNMENT);
        self.bytes.resize(start, 0);
        self.bytes.extend_from_slice(bytemuck::cast_slice(values));
        if values.is_empty() {
            self.bytes.resize(start + Self::ALIGNMENT, 0);
        }
        self.pieces.push((name, start, self.bytes.len() - start));
    }

    /// Everything.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// (name, offset, size) of each piece.
    pub fn pieces(&self) -> &[(&'static str, usize, usize)] {
        &self.pieces
    }
}
