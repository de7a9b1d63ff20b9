//! Which CPUs take interrupts: those of USB controllers, which bring the device's reports, and all others, which only disturb.

use std::fs;

use super::{Finding, cpus, read};

/// Drivers of USB host controllers, as `/proc/interrupts` names them.
const USB_DRIVERS: [&str; 3] = ["xhci", "ehci", "ohci"];

/// One line of `/proc/interrupts` that is a device's.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Line {
    number: u32,
    name: String,
    /// Interrupts so far on each CPU.
    counts: Vec<u64>,
}

/// Where interrupts go, seen from the CPU that the host's real-time thread takes unless told otherwise: the last.
pub fn placement() -> Finding {
    let lines = parse(&read("/proc/interrupts"));
    let Some(&cpu) = cpus::allowed().last() else { return Finding::ok("interrupts", "unknown") };
    let allowed = |number: u32| fs::read_to_string(format!("/proc/irq/{number}/smp_affinity_list")).unwrap_or_default();
    let on_cpu = |line: &&Line| cpus::list(&allowed(line.number)).contains(&cpu);
    judge(cpu, lines.iter().filter(on_cpu).count(), &lines)
}

fn judge(cpu: usize, may: usize, lines: &[Line]) -> Finding {
    let usb: Vec<_> = lines.iter().filter(|line| USB_DRIVERS.iter().any(|driver| line.name.contains(driver))).collect();
    let told = usb.iter().map(|line| format!("{} ({}) on CPU {}", line.number, line.name, busiest(&line.counts)));
    let told = if usb.is_empty() { "none".to_owned() } else { told.collect::<Vec<_>>().join(", ") };
    let found = format!("{may} of {} may be taken on CPU {cpu}, the tick's; of USB: {told}", lines.len());
    let advice = "optional: stop irqbalance, write the other CPUs into /proc/irq/N/smp_affinity_list of what is not the device's";
    Finding { advice: (may > 0).then(|| advice.to_owned()), ..Finding::ok("interrupts", found) }
}

/// The CPU that has taken most.
fn busiest(counts: &[u64]) -> usize {
    let most = counts.iter().enumerate().max_by_key(|(cpu, count)| (**count, usize::MAX - cpu));
    most.map_or(0, |(cpu, _)| cpu)
}

/// Lines that begin with a number; the kernel's own have names.
fn parse(text: &str) -> Vec<Line> {
    let columns = text.lines().next().unwrap_or_default().split_whitespace().count();
    let line = |line: &str| {
        let (number, rest) = line.split_once(':')?;
        let words: Vec<_> = rest.split_whitespace().collect();
        let counts = words.iter().take(columns).map_while(|word| word.parse().ok()).collect();
        Some(Line { number: number.trim().parse().ok()?, name: words.last()?.to_string(), counts })
    };
    text.lines().skip(1).filter_map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn usb_s_interrupts_are_found_with_their_cpu() {
        let text = "           CPU0       CPU1       \n  1:          9          0  IO-APIC   1-edge      i8042\n\
                    130:       1000      99000  PCI-MSI 327680-edge      xhci_hcd\nLOC:     123456     123456   Local timer interrupts\n";
        let lines = parse(text);
        assert_eq!(lines.iter().map(|line| line.number).collect::<Vec<_>>(), [1, 130]);
        let finding = judge(1, 2, &lines);
        assert!(
            finding.found.contains("2 of 2 may be taken on CPU 1") && finding.found.contains("130 (xhci_hcd) on CPU 1"),
            "{finding:?}"
        );
        assert!(finding.advice.is_some() && judge(1, 0, &[]).advice.is_none());
    }
}
