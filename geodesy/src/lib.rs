//! geodesy.
