//! Which library this is.

/// Version of the API that this header describes: major << 22 | minor << 12 | patch.
pub const BGI_API_VERSION: u32 = 4096;
/// Version of the ABI that this header describes. It changes only when a compiled host must be compiled again.
pub const BGI_ABI_VERSION: u32 = 1;

/// API version of the library that was loaded, packed as BGI_API_VERSION is.
#[unsafe(no_mangle)]
pub extern "C" fn bgiGetVersion() -> u32 {
    BGI_API_VERSION
}

/// ABI version of the library that was loaded. Compare with BGI_ABI_VERSION before any other call.
#[unsafe(no_mangle)]
pub extern "C" fn bgiGetAbiVersion() -> u32 {
    BGI_ABI_VERSION
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn api_version_is_the_packages() {
        let part = |text: &str| text.parse::<u32>().unwrap();
        let packed = part(env!("CARGO_PKG_VERSION_MAJOR")) << 22
            | part(env!("CARGO_PKG_VERSION_MINOR")) << 12
            | part(env!("CARGO_PKG_VERSION_PATCH"));
        assert_eq!(BGI_API_VERSION, packed);
    }
}
