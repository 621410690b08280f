//! `oit devices`.

use oit_record::DeviceInfo;

/// Prints every device, usable or not.
pub(crate) fn run() -> miette::Result<()> {
    for listed in oit_gpu::enumerate() {
        match listed.info {
            Ok(info) => print(&info),
            Err(reason) => println!("{}\n  cannot be used: {reason}", listed.id),
        }
    }
    print(&oit_lab::cpu_info());
    match oit_lab::cuda_versions() {
        Ok(versions) => println!("stage cuda\n  {versions}"),
        Err(reason) => println!("stage cuda\n  cannot be used: {reason}"),
    }
    Ok(())
}

fn print(device: &DeviceInfo) {
    println!("{}  {} ({})", device.id, device.name, device.kind);
    println!("  driver               {}", device.driver);
    println!("  API                  {}", device.api);
    if let Some((low, high)) = device.subgroup_size {
        let range = if low == high { low.to_string() } else { format!("{low} to {high}") };
        println!("  subgroup size        {range}");
    }
    // The CPU's twins have no bindings and no workgroups.
    if device.backend != "cpu" {
        println!("  storage buffer       up to {}", bytes(device.max_storage_buffer_bytes));
        println!("  workgroup memory     up to {}", bytes(device.max_workgroup_bytes));
        println!("  workgroup            up to {} invocations", device.max_workgroup_invocations);
    }
    match device.timestamp_period_ns {
        Some(period) => println!("  timestamp            every {period} ns"),
        None => println!("  timestamp            none"),
    }
    if let Some(memory) = device.memory_bytes {
        println!("  device memory        {}", bytes(memory));
    }
    for lacking in &device.unsupported {
        println!("  no {:<17} {}", lacking.feature, lacking.reason);
    }
    println!();
}

fn bytes(count: u64) -> String {
    match count {
        0..1024 => format!("{count} B"),
        1024..1_048_576 => format!("{:.0} KiB", count as f64 / 1024.0),
        1_048_576..1_073_741_824 => format!("{:.0} MiB", count as f64 / 1_048_576.0),
        _ => format!("{:.1} GiB", count as f64 / 1_073_741_824.0),
    }
}
