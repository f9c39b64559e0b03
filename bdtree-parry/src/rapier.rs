//! Bodies of rapier whose contacts move q.
