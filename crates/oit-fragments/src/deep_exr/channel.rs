//! Channels and the numbers in them.

/// How a channel's samples are stored.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum SampleType {
    /// 32-bit unsigned integers, taken for the numbers they are.
    Uint,
    /// 16-bit floats.
    Half,
    /// 32-bit floats.
    Float,
}

impl SampleType {
    /// Bytes of a sample.
    #[must_use]
    pub fn bytes(self) -> usize {
        match self {
            Self::Half => 2,
            Self::Uint | Self::Float => 4,
        }
    }

    /// As it stands in the file, if there is such a type.
    pub(super) fn from_code(code: u32) -> Option<Self> {
        [Self::Uint, Self::Half, Self::Float].get(code as usize).copied()
    }

    /// The sample at this place of a row's samples of one channel.
    #[inline]
    pub(super) fn sample(self, samples: &[u8], i: usize) -> f32 {
        let word = || samples.as_chunks().0[i];
        match self {
            Self::Uint => u32::from_le_bytes(word()) as f32,
            Self::Half => half::f16::from_le_bytes(samples.as_chunks().0[i]).to_f32(),
            Self::Float => f32::from_le_bytes(word()),
        }
    }
}

/// A channel of a file.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Channel {
    /// Its name, its layer's before it where it has one.
    pub name: String,
    /// How its samples are stored.
    pub sample_type: SampleType,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_the_numbers_they_stand_for() {
        assert_eq!(SampleType::Uint.sample(&[0, 0, 0, 0, 1, 1, 0, 0], 1), 257.0);
        assert_eq!(SampleType::Half.sample(&[0, 0, 0x00, 0xbc], 1), -1.0);
        assert_eq!(SampleType::Float.sample(&(-2.5f32).to_le_bytes(), 0), -2.5);
        assert!(SampleType::Half.sample(&[0x01, 0x7c], 0).is_nan());
        assert_eq!(SampleType::from_code(3), None);
    }
}
