"""Compile kernels to an object file by numba and LLVM."""

from collections.abc import Iterable
from typing import Any

import llvmlite.binding as llvm
import numba
from numba import types

from ipoa_mission.compiled.library import Type, words
from tools.machine_code.kernels import Kernel

#: Functions for numba's compiled code. Memory: numba's `MemInfo` (count of references, destructor, its argument, the
#: address, the size) before the data, in one piece of the C library's memory. Reshaping without a copy: strides of a
#: contiguous array that becomes one-dimensional.
RUNTIME = """
declare i8* @malloc(i64)
declare void @free(i8*)
declare void @NRT_decref(i8*)

define i8* @NRT_MemInfo_alloc_aligned(i64 %size, i32 %align) {
  %wide = zext i32 %align to i64
  %room = add i64 %size, 64
  %all = add i64 %room, %wide
  %memory = call i8* @malloc(i64 %all)
  %none = icmp eq i8* %memory, null
  br i1 %none, label %full, label %begin
full:
  ret i8* null
begin:
  %words = bitcast i8* %memory to i64*
  store i64 1, i64* %words
  %here = ptrtoint i8* %memory to i64
  %after = add i64 %here, 64
  %over = urem i64 %after, %wide
  %rest = sub i64 %wide, %over
  %data = add i64 %after, %rest
  %at = getelementptr i64, i64* %words, i64 3
  store i64 %data, i64* %at
  %long = getelementptr i64, i64* %words, i64 4
  store i64 %size, i64* %long
  ret i8* %memory
}

define void @NRT_MemInfo_call_dtor(i8* %memory) {
  call void @free(i8* %memory)
  ret void
}

define i32 @numba_attempt_nocopy_reshape(
  i64 %dimensions, i64* %shape, i64* %strides, i64 %new, i64* %new_shape, i64* %new_strides, i64 %item, i32 %fortran
) {
  %one = icmp eq i64 %new, 1
  br i1 %one, label %flat, label %otherwise
flat:
  store i64 %item, i64* %new_strides
  ret i32 1
otherwise:
  ret i32 0
}

define void @release(i8* %memory) {
  call void @NRT_decref(i8* %memory)
  ret void
}
"""


def type_of(kind: Any) -> Type:
    if isinstance(kind, types.Boolean):
        return "bool"
    if kind == types.int64:
        return "int"
    if kind == types.float64:
        return "float"
    if isinstance(kind, types.Array):
        dtype = numba.np.numpy_support.as_dtype(kind.dtype)
        return f"{dtype.str} {kind.ndim}"
    if isinstance(kind, types.BaseTuple):
        return [type_of(one) for one in kind]
    raise TypeError(f"expected a number, a tuple or an array, not {kind}")


def compiled(kernels: Iterable[Kernel], cpu: str, shown: tuple[str, ...]) -> tuple[bytes, dict[str, list[Any]]]:
    """Return an object file of kernels for a CPU, and the types of each one's arguments and result.

    The object exports the kernels, and the functions of `RUNTIME` named in `shown`.
    """
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    machine = llvm.Target.from_triple(llvm.get_process_triple()).create_target_machine(
        cpu=cpu, opt=3, reloc="pic", codemodel="default"
    )
    whole, index = llvm.parse_assembly(RUNTIME), {}
    whole.triple, whole.data_layout = llvm.get_process_triple(), str(machine.target_data)
    for name, dispatcher, arguments in kernels:
        signature = tuple(map(numba.typeof, arguments))
        dispatcher.compile(signature)
        result = dispatcher.overloads[signature]
        module = llvm.parse_assembly(result.library.get_llvm_str())
        kernel, gives = module.get_function(result.fndesc.mangled_name), result.fndesc.restype
        kernel.name = f"{name}.kernel"
        index[name] = [[type_of(one) for one in signature], None if gives == types.none else type_of(gives)]
        for function in module.functions:
            inner = not function.is_declaration and function.name != kernel.name
            if inner and function.linkage != llvm.Linkage.linkonce_odr:
                function.linkage = llvm.Linkage.internal
        entered = llvm.parse_assembly(entrance(name, kernel, words(index[name][1] or [])))
        whole.link_in(module)
        whole.link_in(entered)
    for function in whole.functions:
        if not function.is_declaration and function.name not in {*index, *shown}:
            function.linkage = llvm.Linkage.internal
    for constant in whole.global_variables:
        if not constant.is_declaration:
            constant.linkage = llvm.Linkage.internal
    passes = llvm.create_new_module_pass_manager()
    passes.add_global_dead_code_eliminate_pass()
    passes.run(whole, llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options()))
    whole.verify()
    return machine.emit_object(whole), index


def entrance(name: str, kernel: Any, returned: int) -> str:
    """Return the source of a function that calls a kernel with a row of words; it returns words and the error.

    A call through ctypes with a hundred arguments takes longer than many kernels.
    """
    types, lines = [str(argument.type) for argument in kernel.arguments], []
    values = [f"{types[0]} %r0", f"{types[1]} %r1"]
    lines += [f"%r0 = bitcast i64* %room to {types[0]}", f"%e = getelementptr i64, i64* %room, i64 {returned}"]
    lines += [f"%r1 = bitcast i64* %e to {types[1]}"]
    how = {"double": "bitcast", "i8": "trunc", "i1": "trunc"}
    for k, kind in enumerate(types[2:]):
        lines += [f"%p{k} = getelementptr i64, i64* %words, i64 {k}", f"%w{k} = load i64, i64* %p{k}"]
        if kind != "i64":
            lines.append(f"%v{k} = {how.get(kind, 'inttoptr')} i64 %w{k} to {kind}")
        values.append(f"{kind} %{'w' if kind == 'i64' else 'v'}{k}")
    lines += [f"%status = call i32 @{kernel.name}({', '.join(values)})", "ret i32 %status"]
    declared = f"declare i32 @{kernel.name}({', '.join(types)})"
    return "\n".join([declared, f"define i32 @{name}(i64* %room, i64* %words) {{", *lines, "}"])
