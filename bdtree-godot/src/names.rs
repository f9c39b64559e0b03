//! Which bone each joint of the file is, and which mode each blend shape: by name, as Godot's importer names things.

use crate::fault::Fault;

/// The name that Godot's glTF and FBX importers give a bone: without `:` and `/`.
fn as_imported(name: &str) -> String {
    name.replace([':', '/'], "_")
}

/// Of each joint the bone that it is: the bone of its name, else the bone that the importer names after it. Bones that no
/// joint is are passed over.
///
/// # Errors
/// A joint without a name or without a bone; two joints of one bone, which happens where the importer has numbered names
/// that come twice.
pub(crate) fn bones_of_joints(joints: &[&str], bones: &[String]) -> Result<Vec<usize>, Fault> {
    let mut found: Vec<usize> = Vec::with_capacity(joints.len());
    for (index, joint) in joints.iter().enumerate() {
        if joint.is_empty() {
            return Err(Fault::UnnamedJoint(index));
        }
        let named = |name: &str| bones.iter().position(|bone| bone == name);
        let bone = named(joint)
            .or_else(|| named(&as_imported(joint)))
            .ok_or_else(|| Fault::NoBone(joint.to_string()))?;
        if let Some(other) = found.iter().position(|known| *known == bone) {
            return Err(Fault::SameBone(
                joints[other].to_string(),
                joint.to_string(),
            ));
        }
        found.push(bone);
    }
    Ok(found)
}

/// Of each blend shape the mode that it moves: the mode of its name, else the one that is called `node/name`, as modes are
/// where several mesh nodes have targets, else one whose `:` the importer has made `_`; in order where no mode has a name
/// and there are as many. `node`: the name of the MeshInstance3D.
///
/// # Errors
/// A blend shape that no mode is; two of one mode; modes without names, of another number.
pub(crate) fn modes_of_shapes(
    modes: &[Option<&str>],
    shapes: &[String],
    node: &str,
) -> Result<Vec<usize>, Fault> {
    if modes.iter().all(Option::is_none) && !shapes.is_empty() {
        if modes.len() != shapes.len() {
            return Err(Fault::ModeCount {
                expected: modes.len(),
                found: shapes.len(),
            });
        }
        return Ok((0..modes.len()).collect());
    }
    let mut found: Vec<usize> = Vec::with_capacity(shapes.len());
    for shape in shapes {
        let of_node = format!("{node}/{shape}");
        let named = |is: &dyn Fn(&str) -> bool| modes.iter().position(|mode| mode.is_some_and(is));
        let mode = named(&|mode| mode == shape)
            .or_else(|| named(&|mode| mode == of_node))
            .or_else(|| named(&|mode| [shape, &of_node].contains(&&mode.replace(':', "_"))));
        let Some(mode) = mode else {
            let own: Vec<_> = modes.iter().flatten().collect();
            return Err(Fault::NoMode(shape.clone(), format!("{own:?}")));
        };
        if let Some(other) = found.iter().position(|known| *known == mode) {
            return Err(Fault::SameMode(shapes[other].clone(), shape.clone()));
        }
        found.push(mode);
    }
    Ok(found)
}

/// Of each bone of the file (a joint with an inverse bind matrix) the bind of Godot's skin. `joint_of`: of each bone its
/// joint; `binds`: of each bind the bone of the skeleton; `places`: of each joint the bone of the skeleton.
///
/// # Errors
/// A joint without a bind, a joint with several bones in the file.
pub(crate) fn binds_of_bones(
    joint_of: &[usize],
    places: &[usize],
    binds: &[Option<usize>],
    joints: &[&str],
) -> Result<Vec<usize>, Fault> {
    let mut found = Vec::with_capacity(joint_of.len());
    for (bone, joint) in joint_of.iter().copied().enumerate() {
        let name = || joints[joint].to_string();
        if joint_of[..bone].contains(&joint) {
            return Err(Fault::SeveralBinds(name()));
        }
        let place = places[joint];
        let bind = binds.iter().position(|bind| *bind == Some(place));
        found.push(bind.ok_or_else(|| Fault::NoBind(name()))?);
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn owned(names: &[&str]) -> Vec<String> {
        names.iter().map(|name| name.to_string()).collect()
    }

    #[test]
    fn joints_find_their_bones_whatever_the_order() {
        let bones = owned(&["root", "arm_left", "arm:right", "arm_right", "tail"]);
        let found = bones_of_joints(&["arm/left", "arm:right", "root"], &bones);
        // A name as it stands goes before the one that the importer makes of it.
        assert_eq!(found.expect("all are there"), [1, 2, 0]);
        let found = bones_of_joints(&[], &bones);
        assert_eq!(found.expect("none are asked for"), []);
    }

    #[test]
    fn joints_that_no_bone_is_are_named() {
        let bones = owned(&["a_b", "c"]);
        let wrong = |joints: &[&str]| {
            bones_of_joints(joints, &bones)
                .expect_err("a fault")
                .to_string()
        };
        assert!(wrong(&["c", "hand"]).contains("\"hand\""));
        assert!(wrong(&["c", ""]).contains("joint 1"));
        let both = wrong(&["a:b", "a/b"]);
        assert!(
            both.contains("\"a:b\"") && both.contains("\"a/b\""),
            "{both}"
        );
    }

    #[test]
    fn blend_shapes_find_their_modes() {
        let modes = [Some("smile"), None, Some("face/blink"), Some("blink")];
        let found = modes_of_shapes(&modes, &owned(&["blink", "smile"]), "face");
        assert_eq!(found.expect("both are there"), [3, 0]);
        let found = modes_of_shapes(&modes[..3], &owned(&["blink"]), "face");
        assert_eq!(found.expect("by the node's name"), [2]);
        let modes_with_colons = [Some("lip:up"), Some("face/lip:down"), Some("lip_low")];
        let shapes = owned(&["lip_low", "lip_down", "lip_up"]);
        let found = modes_of_shapes(&modes_with_colons, &shapes, "face");
        assert_eq!(found.expect("as the importer calls them"), [2, 1, 0]);
        // Without names by their order; a mesh without blend shapes leaves q alone.
        let found = modes_of_shapes(&[None, None], &owned(&["morph_0", "morph_1"]), "face");
        assert_eq!(found.expect("as many"), [0, 1]);
        for modes in [&modes[..], &[None], &[]] {
            let found = modes_of_shapes(modes, &[], "face");
            assert_eq!(found.expect("none are asked for"), []);
        }
    }

    #[test]
    fn blend_shapes_that_no_mode_is_are_named() {
        let wrong = |modes: &[Option<&str>], shapes: &[&str]| {
            modes_of_shapes(modes, &owned(shapes), "face")
                .expect_err("a fault")
                .to_string()
        };
        let text = wrong(&[Some("smile")], &["frown"]);
        assert!(text.contains("frown") && text.contains("smile"), "{text}");
        assert!(wrong(&[None], &["a", "b"]).contains("2 blend shapes"));
        let text = wrong(&[Some("face/a")], &["a", "face/a"]);
        assert!(text.contains("same mode"), "{text}");
    }

    #[test]
    fn binds_are_found_by_bone() {
        let joints = ["hip", "hand"];
        // Joint 0 is bone 7 of the skeleton, joint 1 bone 4; binds 0 and 1 are of bones 4 and 7, bind 2 of none.
        let binds = [Some(4), Some(7), None];
        let found = binds_of_bones(&[1, 0], &[7, 4], &binds, &joints);
        assert_eq!(found.expect("both are there"), [0, 1]);
        let fault = binds_of_bones(&[1, 0], &[7, 4], &binds[..1], &joints).expect_err("no hip");
        assert!(fault.to_string().contains("\"hip\""), "{fault}");
        let fault = binds_of_bones(&[1, 1], &[7, 4], &binds, &joints).expect_err("twice");
        assert!(fault.to_string().contains("\"hand\""), "{fault}");
    }
}
