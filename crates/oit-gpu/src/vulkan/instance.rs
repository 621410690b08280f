//! The Vulkan loader and instance, with the validation layer if it is asked for.

use super::failure;
use crate::GpuError;
use ash::{Entry, ext, vk};
use std::ffi::{CStr, c_void};
use std::rc::Rc;
use std::sync::{Mutex, OnceLock, PoisonError};

const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// A Vulkan instance. Dropping it destroys it.
pub(super) struct Instance {
    pub(super) raw: ash::Instance,
    validation: Option<Validation>,
    // The loaded library, which must outlive every function taken from it.
    entry: Entry,
}

/// The validation layer's messenger, and what it has said.
struct Validation {
    functions: ext::debug_utils::Instance,
    messenger: vk::DebugUtilsMessengerEXT,
    /// Boxed, since the messenger holds its address.
    errors: Box<Mutex<Vec<String>>>,
}

impl Instance {
    /// Loads the loader and makes an instance. With `validate`, the validation layer is enabled if
    /// it is installed; its errors are kept and printed to stderr.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] if there is no loader or no driver.
    pub(super) fn new(validate: bool) -> Result<Rc<Self>, GpuError> {
        // SAFETY: loading the system's Vulkan loader runs its initialisers, which is what it is for.
        let entry = unsafe { Entry::load() }
            .map_err(|error| GpuError::Unsupported(format!("no Vulkan loader: {error}")))?;
        // SAFETY: the entry is loaded.
        let version = unsafe { entry.try_enumerate_instance_version() }
            .map_err(|error| failure("asking for the loader's version", error))?
            .unwrap_or(vk::API_VERSION_1_0);
        if version < vk::API_VERSION_1_3 {
            let version = version_text(version);
            return Err(GpuError::Unsupported(format!(
                "the Vulkan loader is of version {version}, and 1.3 is needed"
            )));
        }
        let validate = validate && lists_validation_layer(&entry);
        let layers = if validate { vec![VALIDATION_LAYER.as_ptr()] } else { vec![] };
        let extensions = if validate { vec![ext::debug_utils::NAME.as_ptr()] } else { vec![] };
        let application = vk::ApplicationInfo::default()
            .application_name(c"oit")
            .api_version(vk::API_VERSION_1_3);
        let create = vk::InstanceCreateInfo::default()
            .application_info(&application)
            .enabled_layer_names(&layers)
            .enabled_extension_names(&extensions);
        // SAFETY: the structures and the names they point to outlive the call.
        let raw = unsafe { entry.create_instance(&create, None) }.map_err(|error| match error {
            vk::Result::ERROR_INCOMPATIBLE_DRIVER => {
                GpuError::Unsupported("no Vulkan driver is installed".to_owned())
            }
            error => failure("creating an instance", error),
        })?;
        keep_drivers_loaded(&application);
        let mut instance = Self { raw, validation: None, entry };
        if validate {
            instance.validation = Some(instance.listen()?);
        }
        Ok(Rc::new(instance))
    }

    /// The errors that the validation layer has reported.
    pub(super) fn validation_errors(&self) -> Option<Vec<String>> {
        let validation = self.validation.as_ref()?;
        Some(validation.errors.lock().unwrap_or_else(PoisonError::into_inner).clone())
    }

    fn listen(&self) -> Result<Validation, GpuError> {
        let errors: Box<Mutex<Vec<String>>> = Box::default();
        let functions = ext::debug_utils::Instance::new(&self.entry, &self.raw);
        let create = vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(vk::DebugUtilsMessageSeverityFlagsEXT::ERROR)
            .message_type(
                vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION
                    | vk::DebugUtilsMessageTypeFlagsEXT::GENERAL,
            )
            .pfn_user_callback(Some(on_message))
            .user_data(std::ptr::from_ref::<Mutex<Vec<String>>>(&errors).cast_mut().cast());
        // SAFETY: the extension is enabled, and `errors` is freed after the messenger.
        let messenger = unsafe { functions.create_debug_utils_messenger(&create, None) }
            .map_err(|error| failure("listening to the validation layer", error))?;
        Ok(Validation { functions, messenger, errors })
    }
}

/// Drivers are unloaded with the last instance. Some cannot be loaded again and again (NVIDIA 580
/// gives out after about twenty times, or crashes), so one instance stays to the end of the process.
fn keep_drivers_loaded(application: &vk::ApplicationInfo) {
    static KEPT: OnceLock<Option<(Entry, ash::Instance)>> = OnceLock::new();
    KEPT.get_or_init(|| {
        let create = vk::InstanceCreateInfo::default().application_info(application);
        // SAFETY: as in `Instance::new`; the instance and the loader are never given back.
        unsafe {
            let entry = Entry::load().ok()?;
            let instance = entry.create_instance(&create, None).ok()?;
            Some((entry, instance))
        }
    });
}

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: all that was made from the instance holds an `Rc` of it and so is gone.
        unsafe {
            if let Some(validation) = &self.validation {
                validation.functions.destroy_debug_utils_messenger(validation.messenger, None);
            }
            self.raw.destroy_instance(None);
        }
    }
}

/// `1.3.230`.
pub(super) fn version_text(version: u32) -> String {
    let (major, minor) = (vk::api_version_major(version), vk::api_version_minor(version));
    format!("{major}.{minor}.{}", vk::api_version_patch(version))
}

/// Whether the validation layer is installed.
pub(super) fn has_validation_layer() -> bool {
    // SAFETY: as in `Instance::new`.
    unsafe { Entry::load() }.is_ok_and(|entry| lists_validation_layer(&entry))
}

fn lists_validation_layer(entry: &Entry) -> bool {
    // SAFETY: the entry is loaded.
    let layers = unsafe { entry.enumerate_instance_layer_properties() }.unwrap_or_default();
    layers.iter().any(|layer| layer.layer_name_as_c_str() == Ok(VALIDATION_LAYER))
}

/// Keeps and prints what the validation layer says.
unsafe extern "system" fn on_message(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _types: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    errors: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layer gives a valid structure for the time of the call.
    let text = unsafe { data.as_ref() }
        .and_then(|data| message_text(data.p_message))
        .unwrap_or_else(|| "a message without text".to_owned());
    eprintln!("vulkan validation: {text}");
    // SAFETY: the messenger was made with the address of this mutex, which outlives it.
    if let Some(errors) = unsafe { errors.cast::<Mutex<Vec<String>>>().as_ref() } {
        errors.lock().unwrap_or_else(PoisonError::into_inner).push(text);
    }
    vk::FALSE
}

fn message_text(text: *const std::ffi::c_char) -> Option<String> {
    // SAFETY: Vulkan's messages are null or end with a zero byte.
    (!text.is_null()).then(|| unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned())
}
