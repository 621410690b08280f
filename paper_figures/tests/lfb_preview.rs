mod synthetic;
#[test]
fn preview() {
    let root = std::path::Path::new("/tmp/lfbprev");
    let _ = std::fs::remove_dir_all(root);
    synthetic::lfb::write_runs(&root.join("records"), "test device");
    let tables = paper_figures::read(&[root.join("records")]).unwrap();
    paper_figures::generate(&tables, &root.join("out"), Some("lfb")).unwrap();
}
