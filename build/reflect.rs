//! What naga knows about a shader, written as Rust.

use naga::valid::{GlobalUse, ModuleInfo};
use naga::{AddressSpace, Expression, GlobalVariable, Handle, ImageClass, Literal, Module, ScalarKind, TypeInner};
use std::collections::BTreeMap;
use std::fmt::Write as _;

fn used<'a>(module: &'a Module, info: &'a ModuleInfo) -> impl Iterator<Item = (&'a GlobalVariable, GlobalUse)> {
    let uses = info.get_entry_point(0);
    module.global_variables.iter().map(move |(handle, var)| (var, uses[handle])).filter(|(_, u)| !u.is_empty())
}

/// Keeps the numbers that the source gave.
pub fn binding_map(module: &Module) -> naga::back::spv::BindingMap {
    let bound = module.global_variables.iter().filter_map(|(_, var)| var.binding);
    bound
        .map(|b| {
            let info =
                naga::back::spv::BindingInfo { descriptor_set: b.group, binding: b.binding, ..Default::default() };
            (b, info)
        })
        .collect()
}

/// `Binding { .. }` expressions of everything that the entry point uses.
pub fn bindings(module: &Module, info: &ModuleInfo) -> String {
    let mut text = String::new();
    for (var, usage) in used(module, info) {
        let Some(binding) = &var.binding else { continue };
        let name = var.name.as_deref().expect("WGSL variables have names");
        let kind = match (&var.space, &module.types[var.ty].inner) {
            (AddressSpace::Uniform, _) => "Uniform",
            (AddressSpace::Storage { .. }, _) => "Storage",
            (_, TypeInner::Image { class: ImageClass::Storage { .. }, .. }) => "StorageImage",
            (_, TypeInner::Image { .. }) => "SampledImage",
            _ => panic!("{name}: no such kind of binding here"),
        };
        let writes = usage.intersects(GlobalUse::WRITE | GlobalUse::ATOMIC);
        write!(
            text,
            "Binding {{ slot: {}, name: {name:?}, kind: BindingKind::{kind}, writes: {writes} }}, ",
            binding.binding
        )
        .expect("a string takes it");
    }
    text
}

fn size_in(module: &Module, space: AddressSpace) -> u32 {
    let vars = module.global_variables.iter().filter(|(_, var)| var.space == space);
    vars.map(|(_, var)| module.types[var.ty].inner.size(module.to_ctx())).sum()
}

/// Bytes of push constants.
pub fn push_bytes(module: &Module) -> u32 {
    size_in(module, AddressSpace::Immediate)
}

/// Bytes of workgroup memory.
pub fn shared_bytes(module: &Module) -> u32 {
    size_in(module, AddressSpace::WorkGroup)
}

/// Rust twins of WGSL structs and constants, each once.
#[derive(Default)]
pub struct Types {
    items: BTreeMap<String, String>,
}

impl Types {
    /// Adds a module's named structs and scalar constants.
    pub fn add_module(&mut self, module: &Module, shader: &str) {
        for (handle, ty) in module.types.iter() {
            if let (Some(name), TypeInner::Struct { members, span }) = (&ty.name, &ty.inner)
                && let Some(text) = struct_text(module, handle, name, members, *span)
            {
                self.add(name, text, shader);
            }
        }
        for (_, constant) in module.constants.iter() {
            let (Some(name), Expression::Literal(literal)) =
                (&constant.name, &module.global_expressions[constant.init])
            else {
                continue;
            };
            let value = match literal {
                Literal::U32(v) => format!("u32 = {v}"),
                Literal::I32(v) => format!("i32 = {v}"),
                Literal::F32(v) => format!("f32 = {v:?}"),
                _ => continue,
            };
            self.add(name, format!("/// WGSL `{name}`.\npub const {name}: {value};\n"), shader);
        }
    }

    fn add(&mut self, name: &str, text: String, shader: &str) {
        let known = self.items.entry(name.to_owned()).or_insert_with(|| text.clone());
        assert!(*known == text, "{shader}: `{name}` differs from the one in another shader");
    }

    /// Leaves out what the others have.
    pub fn without(mut self, others: &Self) -> Self {
        self.items.retain(|name, _| !others.items.contains_key(name));
        self
    }

    pub fn finish(self) -> String {
        self.items.into_values().collect()
    }
}

fn struct_text(
    module: &Module,
    handle: Handle<naga::Type>,
    name: &str,
    members: &[naga::StructMember],
    span: u32,
) -> Option<String> {
    if !module.global_variables.iter().any(|(_, var)| reaches(module, var.ty, handle)) {
        return None;
    }
    let mut text = format!(
        "/// WGSL `{name}`, {span} bytes.\n#[repr(C)]\n#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, \
         bytemuck::Zeroable)]\npub struct {name} {{\n"
    );
    let (mut at, mut pads) = (0, 0);
    let mut pad_to = |offset: u32, at: u32, text: &mut String| {
        if offset > at {
            writeln!(text, "    pub _pad{pads}: [u32; {}],", (offset - at) / 4).expect("a string takes it");
            pads += 1;
        }
    };
    for member in members {
        pad_to(member.offset, at, &mut text);
        let field = member.name.as_deref().expect("WGSL members have names");
        let rust = rust_type(module, member.ty)?;
        writeln!(text, "    /// At byte {}.\n    pub {field}: {rust},", member.offset).expect("a string takes it");
        at = member.offset + module.types[member.ty].inner.size(module.to_ctx());
    }
    pad_to(span, at, &mut text);
    writeln!(text, "}}\nconst _: () = assert!(core::mem::size_of::<{name}>() == {span});").expect("a string takes it");
    for member in members {
        let field = member.name.as_deref().expect("WGSL members have names");
        writeln!(text, "const _: () = assert!(core::mem::offset_of!({name}, {field}) == {});", member.offset)
            .expect("a string takes it");
    }
    Some(text)
}

/// Whether host memory of type `from` holds a `target`.
fn reaches(module: &Module, from: Handle<naga::Type>, target: Handle<naga::Type>) -> bool {
    from == target
        || match &module.types[from].inner {
            TypeInner::Struct { members, .. } => members.iter().any(|m| reaches(module, m.ty, target)),
            TypeInner::Array { base, .. } => reaches(module, *base, target),
            _ => false,
        }
}

fn rust_type(module: &Module, ty: Handle<naga::Type>) -> Option<String> {
    let scalar = |s: &naga::Scalar| match s.kind {
        ScalarKind::Float => Some("f32"),
        ScalarKind::Uint => Some("u32"),
        ScalarKind::Sint => Some("i32"),
        _ => None,
    };
    Some(match &module.types[ty].inner {
        TypeInner::Scalar(s) | TypeInner::Atomic(s) => scalar(s)?.to_owned(),
        TypeInner::Vector { size, scalar: s } => format!("[{}; {}]", scalar(s)?, *size as u32),
        TypeInner::Matrix { columns, rows, scalar: s } if *rows as u32 == 4 => {
            format!("[[{}; 4]; {}]", scalar(s)?, *columns as u32)
        }
        TypeInner::Array { base, size: naga::ArraySize::Constant(n), .. } => {
            format!("[{}; {n}]", rust_type(module, *base)?)
        }
        TypeInner::Struct { .. } => module.types[ty].name.clone()?,
        _ => return None,
    })
}
