//! Environment: model types, record types, grids.

enumeration! {
    /// Model behind an environmental process. SISO-REF-010, UID 248.
    EnvironmentModelType: u8 {
        NO_STATEMENT = 0 "No Statement",
    }
}

enumeration! {
    /// Kind of an environment record. SISO-REF-010, UID 250.
    EnvironmentRecordType: u32 {
        COMBIC_STATE = 256 "COMBIC State",
        FLARE_STATE = 259 "Flare State",
        BOUNDING_SPHERE_RECORD = 65536 "Bounding Sphere Record",
        UNIFORM_GEOMETRY_RECORD = 327680 "Uniform Geometry Record",
        POINT_RECORD_1 = 655360 "Point Record 1",
        LINE_RECORD_1 = 786432 "Line Record 1",
        SPHERE_RECORD_1 = 851968 "Sphere Record 1",
        ELLIPSOID_RECORD_1 = 1048576 "Ellipsoid Record 1",
        CONE_RECORD_1 = 3145728 "Cone Record 1",
        RECTANGULAR_VOLUME_RECORD_1 = 5242880 "Rectangular Volume Record 1",
        RECTANGULAR_VOLUME_RECORD_3 = 83886080 "Rectangular Volume Record 3",
        POINT_RECORD_2 = 167772160 "Point Record 2",
        LINE_RECORD_2 = 201326592 "Line Record 2",
        SPHERE_RECORD_2 = 218103808 "Sphere Record 2",
        ELLIPSOID_RECORD_2 = 268435456 "Ellipsoid Record 2",
        CONE_RECORD_2 = 805306368 "Cone Record 2",
        RECTANGULAR_VOLUME_RECORD_2 = 1342177280 "Rectangular Volume Record 2",
        GAUSSIAN_PLUME_RECORD = 1610612736 "Gaussian Plume Record",
        GAUSSIAN_PUFF_RECORD = 1879048192 "Gaussian Puff Record",
    }
}

enumeration! {
    /// Coordinate system of gridded data. SISO-REF-010, UID 244.
    GridCoordinateSystem: u16 {
        RIGHT_HANDED_CARTESIAN = 0 "Right handed Cartesian (local topographic projection: east, north, up)",
        LEFT_HANDED_CARTESIAN = 1 "Left handed Cartesian (local topographic projection: east, north, down)",
        LATITUDE_LONGITUDE_HEIGHT = 2 "Latitude, Longitude, Height",
        LATITUDE_LONGITUDE_DEPTH = 3 "Latitude, Longitude, Depth",
    }
}

enumeration! {
    /// Whether a grid changes. SISO-REF-010, UID 245.
    ConstantGrid: u8 {
        CONSTANT_GRID = 0 "Constant grid",
        UPDATED_GRID = 1 "Updated grid",
    }
}

enumeration! {
    /// Representation of gridded values. SISO-REF-010, UID 247.
    GridDataRepresentation: u16 {
        TYPE_0 = 0 "Type 0",
        TYPE_1 = 1 "Type 1",
        TYPE_2 = 2 "Type 2",
    }
}
