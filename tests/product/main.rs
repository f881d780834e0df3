//! The product as people run it: its executables, its pages in a browser, hosts in namespaces, logs and recordings.
//!
//! One executable for all of them: linked once, and who waits for a clock does so beside others.

mod common;

mod agents;
mod bluesky;
mod deployed;
mod digests;
mod eye;
mod gateway;
mod handover;
mod hostile;
mod layouts;
mod moves;
mod packaged;
mod page;
mod peers;
mod processes;
mod protected;
mod recordings;
mod reference;
mod reproducibility;
mod returns;
mod scene_keys;
mod seats;
mod siting;
mod standby;
mod terminal;
mod tracker;
mod two_hosts;
mod views;
mod visitors;
mod web;
