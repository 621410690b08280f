//! What the tests share: the devices there are.

/// The ids of the GPUs there are, software ones too. None is a visible skip, and a failure where
/// `OIT_REQUIRE_GPU=1` says that there must be one.
pub(crate) fn gpus() -> Vec<String> {
    let listed = oit_gpu::enumerate();
    let usable: Vec<String> =
        listed.into_iter().filter(|device| device.info.is_ok()).map(|device| device.id).collect();
    if usable.is_empty() {
        let required = std::env::var("OIT_REQUIRE_GPU").is_ok_and(|value| value == "1");
        assert!(!required, "OIT_REQUIRE_GPU=1, and no GPU can be used");
        eprintln!("SKIPPED: no GPU can be used here; `just setup` installs a software one");
    }
    usable
}

/// A folder for compiled pipelines that ends with the test.
pub(crate) fn cache() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}
