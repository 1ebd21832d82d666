//! The machine code of what is done for eight numbers at once: full-width, and free of calls.
//!
//! What the compiler does not inline into a vector function it calls for every
//! operation, at several times the cost, and no result tells of it. So the
//! program reads its own code: `cargo test --release -p rutilant-geom --test instructions`. Where
//! assertions stay on, as in all other tests, much is called.

#![cfg(all(target_arch = "x86_64", target_os = "linux", not(debug_assertions)))]

use iced_x86::{Decoder, DecoderOptions, OpKind};
use object::{Object, ObjectSection, ObjectSymbol, SymbolKind};
use rutilant_geom::{BuildOptions, HitPacket, RayPacket, Surfaces, Vec3};
use std::collections::BTreeMap;

/// A function that was compiled for AVX2.
struct Compiled {
    instructions: usize,
    /// Those with a register of 256 bits.
    wide: usize,
    /// The names of what it calls, but for what lies outside of the program.
    calls: Vec<String>,
}

fn compiled_for_avx2() -> Vec<Compiled> {
    let program = std::fs::read(std::env::current_exe().unwrap()).unwrap();
    let file = object::File::parse(&*program).unwrap();
    let symbols = file.symbols().filter(|s| s.kind() == SymbolKind::Text && s.size() > 0);
    let name =
        |s: &object::Symbol<'_, '_>| format!("{:#}", rustc_demangle::demangle(s.name().unwrap()));
    let functions: BTreeMap<u64, (u64, String)> =
        symbols.map(|s| (s.address(), (s.size(), name(&s)))).collect();
    let vector = functions.iter().filter(|(_, (_, name))| name.ends_with("::vectorize_avx2"));
    let decoded = |(&address, &(size, _)): (&u64, &(u64, String))| {
        let code =
            file.sections().find_map(|s| s.data_range(address, size).ok().flatten()).unwrap();
        let mut compiled = Compiled { instructions: 0, wide: 0, calls: Vec::new() };
        for instruction in &mut Decoder::with_ip(64, code, address, DecoderOptions::NONE) {
            compiled.instructions += 1;
            let is_wide = |i| {
                instruction.op_kind(i) == OpKind::Register && instruction.op_register(i).is_ymm()
            };
            compiled.wide += usize::from((0..instruction.op_count()).any(is_wide));
            if instruction.is_call_near() {
                let target = functions.get(&instruction.near_branch_target());
                compiled.calls.extend(target.map(|(_, name)| name.clone()));
            }
        }
        compiled
    };
    vector.map(decoded).collect()
}

/// Whatever a vector function calls is a rare and long way out, written as one, and the functions
/// that do most of the work mostly use full registers.
#[test]
fn vector_code_is_wide_and_calls_nothing() {
    // What is to be looked at must be in the program.
    let corners = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
    let surfaces =
        Surfaces::new(corners, vec![[0, 1, 2]], vec![], vec![], &BuildOptions::default());
    let rays = RayPacket::NONE;
    assert_eq!(surfaces.closest_packet(&rays).primitive, HitPacket::NONE.primitive);
    assert_eq!(surfaces.occluded_packet(&rays), 0);

    let functions = compiled_for_avx2();
    assert!(functions.len() >= 4, "{} functions", functions.len());
    let mut packets = 0;
    for function in &functions {
        for name in &function.calls {
            let out = [
                "settle",
                "meets",
                "meet_single",
                "near_single",
                "meet_instance",
                "instance_blocks",
                "finish",
            ];
            let known = out.iter().any(|way| name.ends_with(&format!("::{way}")));
            assert!(known || name.contains("panic") || name.contains("fail"), "calls {name}");
        }
        // One ray's functions are shorter, and meet four triangles at a time.
        if function.instructions > 2000 {
            packets += 1;
            println!("{} of {} instructions are wide", function.wide, function.instructions);
            assert!(3 * function.wide > function.instructions);
        }
    }
    assert_eq!(packets, 2, "closest and any hit of eight rays");
}
