//! Methods by name: techniques that are one whole, without a layered fragment buffer.

use std::fmt;

use oit_capture::{Accuracy, Geometry, Method, MethodRequest};
use oit_fragments::{DepthHistogram, Lfb};
use oit_gpu::Plan;

use crate::engine::{CellError, FrameSize};
use crate::technique::{TechniqueError, unknown};

/// Every method, in the order they are listed: those that peel, then those that approximate.
pub fn methods() -> impl Iterator<Item = &'static dyn Method> {
    oit_peel::METHODS.iter().chain(oit_approx::METHODS).copied()
}

/// A method in a size. Its name is the method's, and the size where one is asked for:
/// `dual_peel`, `dual_peel/passes4`.
#[derive(Clone, Copy)]
pub struct MethodChoice {
    /// The method.
    pub method: &'static dyn Method,
    /// How many of what [`Method::size`] says; the method's default where `None`.
    pub size: Option<u32>,
}

impl MethodChoice {
    /// A method in its default size.
    #[must_use]
    pub fn new(method: &'static dyn Method) -> Self {
        Self { method, size: None }
    }

    /// What its picture must be on a view.
    #[must_use]
    pub fn accuracy(&self, histogram: &DepthHistogram) -> Accuracy {
        self.method.accuracy(self.size, histogram)
    }

    /// Its plan on a view.
    ///
    /// # Errors
    /// [`CellError::Unsupported`] where it cannot draw such a view.
    pub fn plan(
        &self,
        geometry: &Geometry,
        size: FrameSize,
        histogram: &DepthHistogram,
    ) -> Result<Plan, CellError> {
        let FrameSize { width_px, height_px } = size;
        let request = MethodRequest { geometry, width_px, height_px, histogram, size: self.size };
        let plan = self.method.build(&request).map_err(CellError::Unsupported)?;
        Ok(Plan { name: self.to_string(), ..plan })
    }

    /// The CPU twin: the picture from the fragments in submission order.
    #[must_use]
    pub fn twin(&self, submitted: &Lfb) -> Vec<[f32; 4]> {
        self.method.twin(self.size, submitted)
    }
}

impl fmt::Display for MethodChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.method.name())?;
        match (self.size, self.method.size()) {
            (Some(n), Some(size)) => write!(f, "/{}{n}", size.word),
            _ => Ok(()),
        }
    }
}

impl fmt::Debug for MethodChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// The method of this name, `NAME` or `NAME/WORDn`.
///
/// # Errors
/// Where there is no such method, or what follows its name is not its size, or out of range.
pub fn parse_method(text: &str) -> Result<MethodChoice, TechniqueError> {
    let (name, word) = match text.split_once('/') {
        Some((name, word)) => (name, Some(word)),
        None => (text, None),
    };
    let method = methods().find(|method| method.name() == name);
    let method = method.ok_or_else(|| unknown("method", name, methods().map(Method::name)))?;
    let Some(word) = word else { return Ok(MethodChoice::new(method)) };
    let wrong = |expected: String| {
        Err(TechniqueError::Size { name: method.name(), word: word.to_owned(), expected })
    };
    let Some(size) = method.size() else { return wrong("it has none".into()) };
    let number = word.strip_prefix(size.word).and_then(|number| {
        // A number has one name: neither `+4` nor `04`.
        number.parse::<u32>().ok().filter(|n| n.to_string() == number)
    });
    match number.filter(|n| size.range.contains(n)) {
        Some(n) => Ok(MethodChoice { method, size: Some(n) }),
        None => {
            let (first, last) = (size.range.start(), size.range.end());
            wrong(format!("it is {}N, N from {first} to {last}", size.word))
        }
    }
}
