//! Shader sources: `#import` of a file once, and bindings numbered in order.

use std::collections::HashSet;
use std::path::Path;

/// Reads a pass with everything that it imports. `@res` becomes the next free `@group(0) @binding(n)`.
pub fn load(root: &Path, path: &Path) -> String {
    let mut text = String::new();
    append(root, path, &mut HashSet::new(), &mut text);
    let mut numbered = String::with_capacity(text.len());
    for (index, part) in text.split("@res ").enumerate() {
        if index > 0 {
            numbered.push_str(&format!("@group(0) @binding({}) ", index - 1));
        }
        numbered.push_str(part);
    }
    numbered
}

fn append(root: &Path, path: &Path, seen: &mut HashSet<String>, text: &mut String) {
    let body = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    for line in body.lines() {
        match line.strip_prefix("#import ") {
            Some(import) if seen.insert(import.to_owned()) => append(root, &root.join(import), seen, text),
            Some(_) => {}
            None => {
                text.push_str(line);
                text.push('\n');
            }
        }
    }
}
