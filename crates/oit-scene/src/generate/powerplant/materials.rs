//! Materials: colour and opacity, 0.05 to 0.3.

pub(super) const GIRDER: [u8; 4] = [120, 125, 135, 46];
pub(super) const PLATE: [u8; 4] = [150, 145, 130, 56];
pub(super) const GRATING: [u8; 4] = [140, 140, 145, 38];
pub(super) const RAIL: [u8; 4] = [225, 190, 50, 77];
pub(super) const TUBE: [u8; 4] = [170, 95, 60, 13];
pub(super) const HEADER: [u8; 4] = [130, 130, 140, 64];
pub(super) const FLANGE: [u8; 4] = [95, 100, 110, 77];
pub(super) const CASING: [u8; 4] = [90, 125, 115, 51];
pub(super) const FIN: [u8; 4] = [185, 190, 195, 26];
pub(super) const TANK: [u8; 4] = [195, 200, 205, 51];
pub(super) const DUCT: [u8; 4] = [175, 165, 145, 31];
pub(super) const CHIMNEY: [u8; 4] = [200, 110, 90, 38];
/// Steam, water, oil, air, gas.
pub(super) const PIPES: [[u8; 4]; 5] = [
    [190, 60, 50, 51],
    [60, 145, 75, 46],
    [120, 85, 60, 64],
    [70, 120, 185, 38],
    [220, 175, 60, 51],
];
