//! What only the deep check reads of a skin.

use std::mem::{offset_of, size_of};
use std::ops::ControlFlow;

use bdtree_fixtures::mutate::{get_u32, put, repair, section};
use bdtree_fixtures::skin::skinned_bar;
use bdtree_format::{ChannelRecord, SectionKind, channel_path};
use bdtree_runtime::Model;

/// The rule has other breaches as well: this one is asked for by name.
#[test]
fn a_channel_of_no_modes_is_refused() {
    let mut bytes = skinned_bar();
    let channel = section(&bytes, SectionKind::CHANNELS).start + 2 * size_of::<ChannelRecord>();
    let count = channel + offset_of!(ChannelRecord, target_count);
    let path = get_u32(&bytes, channel + offset_of!(ChannelRecord, path));
    assert_eq!((path, get_u32(&bytes, count)), (channel_path::MODES, 1));
    put(&mut bytes, count, &0_u32.to_le_bytes());
    repair(&mut bytes);
    let model = Model::from_bytes(&bytes).expect("it opens");
    let mut found = Vec::new();
    model.asset().verify(&mut |error| {
        found.push(error.to_string());
        ControlFlow::Continue(())
    });
    let says = |text: &&String| text.contains("CHAN") && text.contains("at least 1 mode");
    assert_eq!(found.iter().filter(says).count(), 1, "{found:?}");
}
