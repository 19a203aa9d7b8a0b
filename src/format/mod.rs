//! Reading and writing: meshes, images, the lapped-texture record.
