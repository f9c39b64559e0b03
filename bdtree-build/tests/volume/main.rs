//! Given volumes: their files, their surface, and points embedded in them.

mod checks;
mod corpus;
mod embedding;
mod files;
mod gmsh;
mod hostile;
mod shapes;
mod surfaces;
mod vega;
mod vtk;
