// The browser takes no markup from a script of this page, whatever its text is, and no script but the map's worker.
interface Policies {
  createPolicy(name: string, rules: { createScriptURL(address: string): string }): unknown;
}

const policies = (window as unknown as { trustedTypes?: Policies }).trustedTypes;
const worker = new URL("map-worker.js", document.baseURI).href;

policies?.createPolicy("default", {
  createScriptURL(address) {
    if (new URL(address, document.baseURI).href !== worker) throw new TypeError("not a script of this page");
    return address;
  },
});
export {};
