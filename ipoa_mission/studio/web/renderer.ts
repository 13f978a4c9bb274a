// Who draws for this browser: a graphics card, or the processor.
const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;

/** Whether what is drawn is worked out by the processor, which smooth edges cost as much again as all else. */
export function isDrawnBySoftware(): boolean {
  const pen = document.createElement("canvas").getContext("webgl2");
  if (!pen) return false;
  const unmasked = pen.getExtension("WEBGL_debug_renderer_info");
  const name = String(pen.getParameter(unmasked ? unmasked.UNMASKED_RENDERER_WEBGL : pen.RENDERER));
  pen.getExtension("WEBGL_lose_context")?.loseContext();
  return SOFTWARE.test(name);
}
