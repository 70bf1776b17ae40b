// The few instructions of SPIR-V that declare types, variables and their decorations. The numbers
// are those of the SPIR-V specification, version 1.6, chapters 3.7, 3.20 and 3.49.
#include "app/gpu/base/kernel_interface.h"

#include <algorithm>
#include <map>
#include <string>
#include <tuple>

#include "core/base/check.h"

namespace gpu {

namespace {

enum Op : uint32_t {
    kOpTypeInt = 21,
    kOpTypeFloat = 22,
    kOpTypeVector = 23,
    kOpTypeImage = 25,
    kOpTypeSampledImage = 27,
    kOpTypeArray = 28,
    kOpTypeStruct = 30,
    kOpTypePointer = 32,
    kOpConstant = 43,
    kOpVariable = 59,
    kOpDecorate = 71,
    kOpMemberDecorate = 72
};
enum Decoration : uint32_t {
    kDecorationArrayStride = 6,
    kDecorationBinding = 33,
    kDecorationSet = 34,
    kDecorationOffset = 35
};
enum StorageClass : uint32_t {
    kUniformConstant = 0,
    kUniform = 2,
    kPushConstant = 9,
    kStorage = 12
};
constexpr uint32_t kDimBuffer = 5;

using Words = std::span<const uint32_t>;

/// An instruction in pieces: what follows its first word.
struct Instruction {
    uint32_t code;
    Words words;
};

/// Everything that is declared, by id.
struct Declarations {
    std::map<uint32_t, Instruction> types;
    std::map<uint32_t, uint32_t> constants;
    std::vector<std::pair<uint32_t, Instruction>> variables;
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> decorations;  // of (id, decoration)
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> offsets;      // of (structure, member)
};

[[noreturn]] void isNotAKernel(const std::string& why)
{
    throw core::Error("a kernel's SPIR-V has " + why +
                      " — the program was not built in one piece: build it anew");
}

Declarations readDeclarations(Words spirv)
{
    Declarations d;
    if (spirv.size() < 5 || spirv[0] != 0x07230203u) isNotAKernel("no header");
    for (size_t at = 5; at < spirv.size();) {
        const uint32_t code = spirv[at] & 0xffffu;
        const size_t length = spirv[at] >> 16u;
        if (length == 0 || at + length > spirv.size())
            isNotAKernel("an instruction without an end");
        const Instruction in{code, spirv.subspan(at + 1, length - 1)};
        switch (code) {
        case kOpTypeInt:
        case kOpTypeFloat:
        case kOpTypeVector:
        case kOpTypeImage:
        case kOpTypeSampledImage:
        case kOpTypeArray:
        case kOpTypeStruct:
        case kOpTypePointer:
            d.types.insert({in.words[0], in});
            break;
        case kOpConstant:
            d.constants[in.words[1]] = in.words[2];
            break;
        case kOpVariable:
            d.variables.emplace_back(in.words[1], in);
            break;
        case kOpDecorate:
            d.decorations[{in.words[0], in.words[1]}] = in.words.size() > 2 ? in.words[2] : 0;
            break;
        case kOpMemberDecorate:
            if (in.words[2] == kDecorationOffset)
                d.offsets[{in.words[0], in.words[1]}] = in.words[3];
            break;
        default:
            break;
        }
        at += length;
    }
    return d;
}

/// Bytes of a type of push constants, without padding at its end.
uint32_t bytesOf(const Declarations& d, uint32_t type)
{
    const auto found = d.types.find(type);
    if (found == d.types.end()) isNotAKernel("push constants of an unknown type");
    const Instruction& in = found->second;
    switch (in.code) {
    case kOpTypeInt:
    case kOpTypeFloat:
        return in.words[1] / 8;
    case kOpTypeVector:
        return in.words[2] * bytesOf(d, in.words[1]);
    case kOpTypeArray:
        return d.constants.at(in.words[2]) * d.decorations.at({type, kDecorationArrayStride});
    case kOpTypeStruct: {
        uint32_t end = 0;
        for (uint32_t m = 1; m < in.words.size(); ++m)
            end = std::max(end, d.offsets.at({type, m - 1}) + bytesOf(d, in.words[m]));
        return end;
    }
    default:
        isNotAKernel("push constants of an unknown type");
    }
}

/// Sets the kind of a texel buffer from its type.
void readTexels(const Declarations& d, uint32_t type, KernelBinding& binding)
{
    const auto at = [&](uint32_t id) -> const Instruction& {
        const auto found = d.types.find(id);
        if (found == d.types.end()) isNotAKernel("a resource of an unknown type");
        return found->second;
    };
    const Instruction* image = &at(type);
    if (image->code == kOpTypeSampledImage) image = &at(image->words[1]);
    if (image->code != kOpTypeImage || image->words[2] != kDimBuffer)
        isNotAKernel("an image, which no kernel here is given");
    binding.type = VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
    binding.uintTexels = at(image->words[1]).code == kOpTypeInt;
}

}  // namespace

std::vector<KernelBinding> KernelInterface::ofSet(uint32_t set) const
{
    std::vector<KernelBinding> result;
    std::ranges::copy_if(bindings, std::back_inserter(result),
                         [set](const KernelBinding& b) { return b.set == set; });
    return result;
}

KernelInterface readKernelInterface(std::span<const uint32_t> spirv)
{
    const Declarations d = readDeclarations(spirv);
    KernelInterface result;
    for (const auto& [id, variable] : d.variables) {
        const uint32_t storage = variable.words[2];
        if (storage != kUniformConstant && storage != kUniform && storage != kPushConstant &&
            storage != kStorage)
            continue;
        const uint32_t type = d.types.at(variable.words[0]).words[2];  // what the pointer points to
        if (storage == kPushConstant) {
            result.pushBytes = bytesOf(d, type);
            continue;
        }
        KernelBinding binding;
        binding.set = d.decorations.at({id, kDecorationSet});
        binding.binding = d.decorations.at({id, kDecorationBinding});
        if (storage == kUniform) binding.type = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
        if (storage == kUniformConstant) readTexels(d, type, binding);
        result.bindings.push_back(binding);
    }
    std::ranges::sort(result.bindings, {},
                      [](const KernelBinding& b) { return std::tie(b.set, b.binding); });
    return result;
}

}  // namespace gpu
