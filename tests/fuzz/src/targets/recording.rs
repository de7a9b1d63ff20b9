//! A recording, computed again.

use haptor_engine::replay::verify;
use haptor_wire::recording::written_by;

use super::mend;

/// Ticks of an input at most: some are long recordings, and a target should look at many inputs.
const MOST_BYTES: usize = 32 << 10;

/// Bytes as they are, and mended.
pub fn run(bytes: &[u8]) {
    let bytes = &bytes[..bytes.len().min(MOST_BYTES)];
    for mut file in [bytes.to_vec(), mend::recording(bytes)] {
        let _ = written_by(&file);
        let (length, mut last) = (file.len(), 0);
        let verdict = verify(&mut file, |at| {
            assert!(last <= at && at <= length);
            last = at;
        });
        let Ok(verdict) = verdict else { continue };
        let counts = verdict.counts;
        assert_eq!(counts.ticks, counts.verified + counts.different + counts.unverifiable + counts.idle, "{counts:?}");
        assert!(verdict.damaged_bytes <= length as u64);
    }
}
