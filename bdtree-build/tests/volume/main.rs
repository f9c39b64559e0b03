//! Given volumes: their files, their surface, and points embedded in them.

mod bodies;
mod checks;
mod corpus;
mod embedding;
mod files;
mod gmsh;
mod hostile;
mod located;
mod outside;
mod shapes;
mod surfaces;
mod vega;
mod vtk;
