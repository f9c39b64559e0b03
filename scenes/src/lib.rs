//! The paper's experiments: programs ([`chairs`] and [`fish`] with what [`falling`] has, [`curtain`], [`tables`], [`growth`], [`results`] with [`logs`]),
//! the guide's plots ([`guide`]) and films ([`film`]) with what they share and workloads for benchmarks.

pub mod chairs;
pub mod contenders;
pub mod curtain;
pub mod falling;
pub mod film;
pub mod fish;
pub mod growth;
pub mod guide;
pub mod hierarchies;
pub mod logs;
pub mod report;
pub mod results;
pub mod tables;
pub mod workloads;
