//! Pictures of assets: deformed meshes and the spheres of their trees.
