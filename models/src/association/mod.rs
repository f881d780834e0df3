//! association.
