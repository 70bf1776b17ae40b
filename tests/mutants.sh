#!/usr/bin/env bash
# The test of the tests: plants one known fault at a time in a copy of the sources, and demands that the tests named
# beside it fail. Run by `./test --mutants`; takes about a minute and a half per fault on two cores.
#   tests/mutants.sh [NAME...]   only the faults of these names
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
copy=$root/build-mutants/source
build=$root/build-mutants/build

# name @ file @ what to replace, to the letter @ by what @ tests that must notice
faults='
missing-cosine@shaders/shared/connection.h@e.radiance * (abs(wi.z) * weight)@e.radiance * weight@Furnace*:Direct*
missing-pi@shaders/shared/bsdf.h@f = b.diffuse * kInvPi;@f = b.diffuse;@Bsdf*:Furnace*
paths-of-a-block-mixed@core/methods/path_kernel_body.h@block.paths[b] = i;@block.paths[b] = wave.active[first];@PathAlone*
holes-of-emitters-forgotten@core/scene/world_emitters.cpp@(hasAlphaTest(m) ? shared::kEmitterAlpha : 0u)@0u@Direct*:GpuPath*
half-vector-jacobian@shaders/shared/microfacet.h@r.pdf = 0.5f * d / (depth * wo.z + rootO);@r.pdf = d / (depth * wo.z + rootO);@Bsdf*
mis-swapped@shaders/shared/connection.h@powerHeuristic(pmf * e.pdf, pdf)@powerHeuristic(pdf, pmf * e.pdf)@Furnace*:Direct*:Path*
light-pdf-in-area@shaders/shared/emitter.h@float pdf = 2.0f * distance * distance / projected;@float pdf = 2.0f / projected;@Emitter*:Direct*
roulette-unpaid@shaders/shared/path.h@path.beta *= 1.0f / survival;@@Furnace*:Path*
environment-sine@shaders/shared/lights.h@texelPmf * texels / (2.0f * kPi * kPi * sinTheta)@texelPmf * texels / (2.0f * kPi * kPi)@*Environment*:Furnace*:Light*
shared-seed@shaders/shared/sampler.h@s.pixel = pixel.x | (pixel.y << 16u);@s.pixel = (pixel.x >> 1u) | (pixel.y << 16u);@Sampler*:Rng*
last-sample-dropped@shaders/film/accumulate.comp@s < batch.sampleCount;@s + 1u < batch.sampleCount;@*GpuPath*-*.Slow*
film-uncompensated@shaders/shared/film.h@    lost = rounded;@    lost = vec3(0.0f);@FilmGpu*
film-packing@shaders/shared/film.h@p.sumLost = vec3(w.word0.w, w.word1.x, w.word1.y);@p.sumLost = vec3(w.word0.w, w.word1.y, w.word1.x);@FilmGpu*
purpose-ignored@shaders/shared/sampler.h@s.seed = seed ^ (purpose * 0x9e3779b9u);@s.seed = seed;@Sampler*
half-pixel-shift@shaders/shared/camera.h@2.0f * film.x / size.x - 1.0f@2.0f * (film.x + 0.5f) / size.x - 1.0f@Camera*:*Aov*:Path*
back-face-normal@shaders/shared/surface.h@n = ensureVisible(side * n, -direction);@n = ensureVisible(n, -direction);@Furnace*:Path*:Direct*
normal-map-behind@shaders/shared/surface.h@s.frame * vec3(side * m.x, side * m.y,@s.frame * vec3(m.x, m.y,@DirectLight.NormalMaps*
medium-forgotten@shaders/shared/path.h@    path.medium = mediumBeyond(path.medium, vertex, side);@@Media.*
medium-connections@shaders/shared/connection.h@e.radiance *= transmittance(scene, mediumBeyond(path.medium, vertex, side), e.distance);@;@Media.*
reuse-old-lobes@shaders/shared/reuse_view.h@v.bsdfBefore = makeBsdf(evaluateMaterial(scene, s, -towardsBefore).inputs);@v.bsdfBefore = v.vertex.bsdf;@*ReuseBias.NormalMaps*
eta-squared@shaders/shared/bsdf.h@? 1.0f / (b.eta * b.eta) : 1.0f;@? 1.0f : 1.0f;@Bsdf*
reuse-alpha-unscaled@shaders/shared/reuse.h@Real cq = c * q;@Real cq = q;@Reuse*
reuse-ris-weight@shaders/shared/reuse.h@r.sum / (k * n * r.p)@r.omega / (n * r.p)@Lab.Every*
reuse-keep-unpaid@shaders/shared/reuse.h@min(kappa / score, Real(kInfinity)) : Real(1.0f)@Real(1.0f) : Real(1.0f)@Resample*:Lab.History*
reuse-count-for-nominal@core/reuse/reweighting_augmentation.h@fraction.alphaOverQ(q, p) / N;@fraction.alphaOverQ(q, p) / static_cast<typename C::Real>(old.size());@Lab.Flatland*
reuse-after-trace-unpaid@core/reuse/reweighting_augmentation.h@draw.u * share / draw.omega@draw.u * share@Lab.Traps*
reuse-correction-sign@core/reuse/change.h@static_cast<Real>(1 - weightSum)@static_cast<Real>(weightSum - 1)@Lab.Every*
reuse-bent-twice@shaders/shared/reuse_new.h@if (trail.bends && !keepsDirections(settings)) alpha@if (trail.bends) alpha@*ReuseMirrors*cpu*
reuse-lamp-twice@shaders/shared/reuse_new.h@packRgbe(max(L - trail.emitted, vec3(0.0f)),@packRgbe(L,@*ReuseMirrors*cpu*
reuse-residual-alone@shaders/shared/reuse_new.h@: reconnection(way, n, position, v.positionBefore);@: 1.0f;@*ReuseMethod*cpu*:*ReuseBias*cpu*
reuse-slide-unpaid@shaders/shared/reuse_shift.h@    r.u *= lengths * lengths;@    if (false) @ReuseShift*
reuse-taps-nearest@shaders/shared/reuse_path.h@return 0.001f + 0.998f * unit;@return vec2(0.5f);@ReuseShift*
reuse-first-hits-on-edges@shaders/shared/reuse_path.h@insideTriangle(triangleInSlot(scene, hit.slot), hit.barycentrics)@hit.barycentrics@*ReuseEdges*cpu*
reuse-remainder-whole@core/methods/reuse_competition_body.h@remainder -= scale * brings[i];@@*ReuseMethod*cpu*:*ReuseBias*cpu*
reuse-remainder-forgotten@shaders/shared/reuse_sums.h@const vec3 sum = s.carried + s.remainder;@const vec3 sum = s.remainder;@*ReuseMethod.AFew*cpu*
detail-light-across@app/pictures/fine_light.cpp@if (!oneSurface(here, there)) continue;@@FineLight*
detail-of-the-view-before@app/pictures/picture_work.cpp@renderer.surfaces(ahead, fineSize_, sightOf(request))@renderer.surfaces(request.camera, fineSize_, sightOf(request))@*PictureWorkInMotion.TheyAre*:MovingOn*
detail-goes-back@app/pictures/picture_work.cpp@(published_ > 0 || ahead == request.camera || ahead == light.shown)@(ahead == light.shown)@*PictureWorkInMotion*
detail-light-moves-along@app/pictures/fine_light.cpp@p.point = from_ + rays_.point(x, y, depth);@p.point = rays_.point(x, y, depth);@FineLight.ACamera*
detail-behind-panes-aside@shaders/shared/seen.h@way.distance += hit.t;@way.distance = hit.t;@*Seen.*
detail-mirrored-normals@shaders/shared/seen.h@found.normal = way.turn * found.normal;@@*Seen.*Mirrors*
edges-beside-their-cuts@shaders/shared/display.h@clamp(0.5f + ahead@clamp(0.6f + ahead@EdgeCuts*
detail-off-centre@shaders/shared/path_state.h@camera.centred != 0u ? vec2(0.5f, 0.5f) : streamVec2@streamVec2@Methods.Centred*
detail-guide-beyond@app/pictures/preview_shading.cpp@of.resize(stride_ * (size_t(size.y) + 1));@of.resize(stride_ * (size_t(size.y) + 1), 1);@MovingDetail*:PreviewShading*
reuse-rest-blotches@shaders/shared/reuse_sums.h@min(s.nominal * inversesqrt(max(magnified, 1.0f)), kReuseMostAtRest)@s.nominal@*ReuseRest.Small*cpu*
reuse-rim-of-blocks@shaders/shared/reuse_history.h@if (magnified < 2.0f || !inside) {@if (true) {@*ReuseRest.Larger*cpu*
reuse-rest-variance@shaders/shared/reuse_sums.h@s.part * weight / (s.nominal + s.rays);@s.part;@ReuseShared*
reuse-rays-unpaid@shaders/shared/reuse_new.h@(trail.omega * v.rays)@trail.omega@*ReuseMethod*cpu*:*ReuseBias*cpu*
reuse-paths-change-c@core/methods/reuse_estimator_body.h@p.taken = shared::takeRays(job_.settings, p.v.rays * part, p.v.history);@p.v.c = shared::shareOfHistory(job_.settings, p.v.history, p.v.rays *= part); sums.rays = p.v.rays; p.taken = shared::takeRays(job_.settings, p.v.rays, p.v.history);@*PathAllocation*MeanStays*cpu*
motion-new-side@shaders/shared/reuse_new.h@const bool old = wayIsOld(scene, settings, v, way, ends, triangle) &&@const bool old = true &&@*ReuseMotion.Shadows*cpu*
motion-old-arrivals@core/methods/reuse_estimator_body.h@if (!shared::arrivingIsOld(job_.scene, job_.settings, place, r)) continue;@@*ReuseMotion.Light*cpu*
motion-camera-rests@shaders/shared/motion.h@    camera.position = m.now + m.turn * (camera.position - m.before);@@Motion.*:*ReuseMotion.WhatMoves*cpu*
reuse-light-share@shaders/shared/reuse_new.h@result.light.v = (1.0f - share) / v.rays;@result.light.v = 1.0f;@*ReuseMethod*cpu*:*ReuseBias*cpu*
reuse-candidates-at-rest@shaders/shared/reuse_new.h@if (!augments || follows ||@if (!augments || (follows && v.c < 0.0f) ||@*ReuseRest*cpu*
reuse-hidden-kept@shaders/shared/reuse_visibility.h@if (!asksAgain(settings, stream, which)) return false;@return false;@*ReuseBias.Asking*cpu*
reuse-pane-unpassed@core/methods/reuse_paths_body.h@if (wave_.blocked[s] != 0 && !comesThrough(c.shadow, wave_.rays[s].seed)) continue;@if (wave_.blocked[s] != 0) continue;@Panes*:*ReusePanes*cpu*
reuse-pane-undimmed@shaders/shared/reuse_visibility.h@if (FEATURE(kFeaturePanes)) F *= unpackThrough(r.through);@@*ReusePanes*cpu*
reuse-pane-stale@shaders/shared/reuse_visibility.h@    F = shadow.contribution;@@*ReusePanesAsked*cpu*
reuse-pane-hides@shaders/shared/reuse_visibility.h@ends ? distance : kInfinity, mostPanes(path, 0u, shadow.pdf),@ends ? distance : kInfinity, 0u,@*ReusePanes*cpu*
reuse-other-side@shaders/shared/reuse_history.h@behind == (s.backFace != 0u) &&@@*ReuseMethod*cpu*:*ReuseBias*cpu*
completion-run-mass@core/completion/row_weights.cpp@raise(piece.begin, piece.end, share / length_[piece.run]);@raise(piece.begin, piece.end, share);@RowWeights*
completion-no-complement@core/completion/basis.cpp@return neverSame ^ neverDiffer;@return neverDiffer;@Basis*:Matching*
completion-key-spill@core/completion/basis.cpp@filling = end > 64 ? bits >> (64 - part.shift) : 0;@filling = 0;@Basis*
completion-residual-unpaid@core/completion/matching.cpp@static_cast<float>(1 / apartProbability_)@1.0f@Residual*
completion-rate-stays@core/completion/matching.cpp@basis_.matchesSamples(key_)) raiseRate();@basis_.matchesSamples(key_)) {}@Matching*
completion-rows-alike@core/completion/matching.cpp@return std::clamp(kMeanLight * brightest, kDimmest, kBrightest);@return kMeanLight;@Matching*
completion-stray-trusted@core/completion/repair.cpp@if (strays()) return RepairOutcome::hopeless;@@Repair*
completion-probes-trusted@core/completion/repair.cpp@return !findsWrong(true);@return true;@Repair*
completion-borders-everywhere@core/completion/repair.cpp@if (countBits(memory_.ask) > most_)@if (false)@Repair*
completion-never-probed@core/completion/repair.cpp@if (trust_.probes > 0 && !probe())@if (false)@Repair*
completion-halves-unfolded@core/completion/row_counts.cpp@foldHalves();@@RowCounts*
slice-sides-alike@core/many_lights/slice_rows.cpp@if (anySideDiffers_)@if (false)@SliceRows*
slice-media@core/many_lights/slice_rows.cpp@if (anyAbsorbs_ && column.light->kind != LightKind::directional) dimLight(rows, weights);@@Media.*
slice-media-kernel@shaders/shared/virtual_light.h@return exp(-length(towards) * (behind ? r.absorptionBehind : r.absorption));@return vec3(1.0f);@Media.*
slice-opaque@core/many_lights/slice_rows.cpp@return !anyTransmits_ && mostEvents_ < mostEventsBefore(column, settings);@return mostEvents_ < mostEventsBefore(column, settings);@SliceRows*
slice-never-deep@core/many_lights/slice_rows.cpp@return !anyTransmits_ && mostEvents_ < mostEventsBefore(column, settings);@return !anyTransmits_;@SliceRows*
slice-first-word@core/many_lights/slice_shading.cpp@visible.subspan(begin, end - begin)@visible.subspan(0, end - begin)@SliceQueue*
completion-unknown-untraced@core/completion/matching.cpp@rest_[w] = matters[w] & ~known[w];@rest_[w] = 0;@Matching*
completion-pivot-lost@core/completion/gauss_jordan.cpp@if (getBit(this->column(k), pivot))@if (false)@GaussJordan*
bvh-no-way-back@core/trace/bvh_traverse.h@stack[++top] = back;@@BvhFar*
bvh-device-no-way-back@shaders/traverse.glsl@enters ? (popped != kBvhDone ? 1 : 0) : -1;@enters ? 0 : -1;@GpuTraverse.Far*
instance-alpha-alike@shaders/shared/surface.h@triangle + instance * 0x9e3779b1u@triangle@InstancedRays.EachInst*
instance-not-back@core/trace/bvh_traverse.h@ray = LocalRay(origin, direction);@@InstancedRays.Own*
instance-slots-device@shaders/traverse.glsl@hit.slot = found ? slot + ray.offset : hit.slot;@hit.slot = found ? slot : hit.slot;@*InstancesLook*
instance-mirrored@core/scene/world_geometry.cpp@if (mirrored) std::swap(w.v1, w.v2);@@Instances.Show*:World*
bvh-one-grid@core/trace/bvh_grid.h@count >= all / 64 ? 2.0f : 0.25f@0.0f@BvhFar*
bvh-one-scale@core/trace/bvh_builder.cpp@kMinStep * split.left.extent() <= bounds.box.extent()@false@BvhFar*
bvh-entry-apart@core/trace/bvh_entry.cpp@leafMeets(bvh, entry.surroundings, outer.record(whole, 0)) ? 0 : 1@1@BvhFar*
bvh-entry-ends@shaders/shared/intersect.h@within.x <= tMin && tMax < within.y@within.x <= tMin@BvhFar*
bvh-no-reach@core/trace/bvh_builder.cpp@if (parts) consider(findReachSplit(span(range), bounds));@@BvhFar*
bvh-refit-old-grid@core/trace/bvh_refit.cpp@bvh::writeGridChange(&nodes[2 * size_t(change)], finer, grid, root);@@BvhFar*
coat-emission-flat@shaders/shared/lights.h@s.radiance = coatedEmission(scene, e, s.barycentrics, s.wi);@;@CoatedLamp.*
light-rims-dark@shaders/shared/virtual_light.h@    if (!(side * local.z > 0.0f)) {@    if (!(side * local.z > 0.0f)) return vec3(0.0f); if (false) {@VirtualLights.SendWhat*:ManyLights.*CoarseSmooth*
whole-pairs-that-differ@core/many_lights/whole_pairs.cpp@return visible == 0 ? Agreement::hidden : Agreement::none;@return Agreement::hidden;@WholePairs*
whole-pairs-backs-of-lights@core/many_lights/whole_pairs.cpp@above(l.axis, -1)@above(l.axis, 1)@WholePairs*
dark-rows-by-chance@core/many_lights/dark_rows.cpp@if (!sees && kLooks * rough.of(i) < kExpected * light_[row]) continue;@@DarkRows*
particle-rims-dark@core/many_lights/light_particle.cpp@constexpr float kBetween = 0.25f;@constexpr float kBetween = 0;@ManyLights.*CoarseSmooth*
coat-light-flat@core/many_lights/light_paths.cpp@white.clearcoat = coat;@@CoatedLamp.*
coat-light-weakened@core/many_lights/light_paths.cpp@surface.bsdf.parts |= shared::kLightEmits;@@CoatedLamp.*
diffuse-rims-flat@core/many_lights/light_paths.cpp@if (shared::isLambert(v.bsdf) && met.angle < kWide) {@if (shared::isLambert(v.bsdf)) {@VirtualLights.*Rims*
rims-bent-twice@core/many_lights/light_particle.cpp@if (v.wo.z > kMostOfBent) return surface;@return surface;@VirtualLights.*Rims*
bounds-of-flat-cones@core/many_lights/row_bounds.cpp@    cone.sine[word] = sine;@    cone.sine[word] = 0;@RowBounds*
cover-shone-through@core/many_lights/shadow_packets.h@shared::connectionEnd(std::sqrt(squared))@0.9999f@Techniques.ACover*
shadow-run-elsewhere@core/many_lights/shadow_packets.h@traceRun(target, 64 * w + i, visible + w, i);@traceRun(target, 64 * w, visible + w, i);@ShadowPackets*
shadow-run-one-seed@core/many_lights/shadow_packets.cpp@shared::hashUint(target.seed ^ seeds[i])@shared::hashUint(target.seed ^ seeds[0])@ShadowPackets*
pilot-believed@core/many_lights/light_paths.cpp@if (pilot.lights.empty()) return static_cast<uint32_t>(most);@if (pilot.lights.empty()) return 0;@VirtualLights*
pane-light-twice@core/many_lights/lost_light.cpp@walk.path.pdf = walk.pdf;@walk.path.pdf = 0;@ManyLightsBehindPanes*
pane-unpassed@core/many_lights/lost_light.cpp@if (panes) connectReceiver(job, scene, r, v, n, walk, wave);@@Panes*
reuse-border-hands-on@core/methods/reuse_estimator_body.h@if (!shared::isPixelOf(size, middle)) return -1;@@*ReuseEdges*
guided-convergence-misled@core/guiding/convergence.cpp@fall - 2 * std::sqrt(spread) / second@fall@PictureConvergence*
guided-own-numbers@core/methods/guide_training.cpp@return views_ == 0 ? params_.seed@return true ? params_.seed@*GuideKnowsWhat*
guided-never-again@core/methods/guide_training.cpp@rested_ >= patience_@false@*IsTriedAgain*
guided-trial-short@core/methods/guide_training.cpp@moves && !again ? kLessonsOfMovingTrial@false ? kLessonsOfMovingTrial@*FlightWhereItPaysLate*
guided-density-forgotten@shaders/shared/guided_path.h@if (guidePdf == kAsPdfGuide) guidePdf = pdfGuide(guide, leaf, wi);@if (guidePdf == kAsPdfGuide) guidePdf = 0.0f;@GuidedPath.*
shallow-compiles@app/gpu/path_batches.cpp@!megakernel_.isCompiled(work_.constants);@false;@GpuPace.*
srgb-twice@shaders/shared/tonemap.h@pow((x + 0.055f) * (1.0f / 1.055f), 2.4f)@pow((x + 0.055f) * (1.0f / 1.055f), 5.76f)@Tone*:Image*:Gltf*
'

mkdir -p "$copy"
git -C "$root" ls-files -z --cached --others --exclude-standard |
    tar -C "$root" --null --ignore-failed-read -T - -cf - | tar -C "$copy" -xf -
cmake -S "$copy" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release >/dev/null
export CCACHE_NOHASHDIR=1 CCACHE_BASEDIR="$copy"

# The lines of those that are to be planted.
chosen() {
    while IFS= read -r line; do
        if [ -n "$line" ] && { [ $# -eq 0 ] || [[ " $* " == *" ${line%%@*} "* ]]; }; then echo "$line"; fi
    done <<<"$faults"
}
# Runs the tests of a filter; what they say goes to a file.
passes() {
    local filter=$1 negative=${1##*-}
    [ "$negative" != "$filter" ] || filter="$filter:-*.Slow*"
    timeout 600 "$build/tests" --gtest_brief=1 --gtest_filter="$filter" >"$2" 2>&1
}

# What fails without any fault would seem to notice each.
ninja -C "$build" tests >"$build/log" 2>&1
while IFS='@' read -r name file from to filter; do
    passes "$filter" "$build/$name.txt" || { echo "$filter fails without a fault, see $build/$name.txt" >&2; exit 1; }
done < <(chosen "$@")

caught=0 missed=0
while IFS='@' read -r name file from to filter; do
    FROM=$from TO=$to perl -0pi -e 's/\Q$ENV{FROM}\E/$ENV{TO}/' "$copy/$file"
    if cmp -s "$copy/$file" "$root/$file"; then
        echo "mutant $name: '$from' is no longer in $file" >&2
        missed=$((missed + 1))
        continue
    fi
    if ! ninja -C "$build" tests >"$build/log" 2>&1; then
        echo "mutant $name: does not compile, see $build/log" >&2
        missed=$((missed + 1))
        cp "$root/$file" "$copy/$file"
        continue
    fi
    if passes "$filter" "$build/$name.txt"; then
        echo "mutant $name: SURVIVED $filter"
        missed=$((missed + 1))
    else
        echo "mutant $name: caught by $(grep -c '^\[  FAILED  \] [A-Za-z/0-9_]*\.' "$build/$name.txt") test(s)"
        caught=$((caught + 1))
    fi
    cp "$root/$file" "$copy/$file"  # a new time stamp: whatever was built from the fault is built again
done < <(chosen "$@")
echo "$caught passed, $missed failed"
[ "$missed" -eq 0 ]
