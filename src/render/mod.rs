//! From a surface texture to a picture.
