//! A body as the cache folder keeps it.

use haptor_mesh::body::Body;
use haptor_mesh::kept::{Keep, Key};

/// As the contents of a file, which are trusted no more than the file, and as a file.
pub fn run(bytes: &[u8]) {
    let _ = Body::KIND.open(bytes);
    let sealed = Body::KIND.seal(&Key([0; 32]), bytes);
    let (_, contents) = Body::KIND.open(&sealed).expect("what was sealed is opened");
    assert_eq!(contents, bytes);
    let Ok(body) = Body::from_contents(bytes) else { return };
    // by their bytes: some numbers may be none
    let kept = body.to_contents();
    let again = Body::from_contents(&kept).expect("what was kept comes back");
    assert_eq!(again.to_contents(), kept);
    for part in &body.parts {
        let _ = part.baked.shape();
    }
}
