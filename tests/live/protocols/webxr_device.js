// A WebXR device of the test's: what `device.body` and `device.hands` hold is tracked.
window.device = { body: null, hands: {}, frames: 0 };
window.XRWebGLLayer = class {};
const pose = (at) => ({
  transform: {
    position: { x: at[0], y: at[1], z: at[2] },
    orientation: { x: at[3], y: at[4], z: at[5], w: at[6] },
  },
});
class Session extends EventTarget {
  updateRenderState() {}
  async requestReferenceSpace(kind) { return { kind }; }
  get inputSources() {
    return Object.entries(device.hands).map(([handedness, joints]) => ({
      handedness, hand: new Map(Object.entries(joints)),
    }));
  }
  requestAnimationFrame(step) {
    setTimeout(() => {
      device.frames += 1;
      const body = device.body && new Map(Object.entries(device.body));
      step(performance.now(), { session: this, body, getPose: (space) => space && pose(space) });
    }, 16);
  }
}
Object.defineProperty(navigator, "xr", {
  value: {
    isSessionSupported: async (kind) => kind === "immersive-ar",
    requestSession: async (kind, options) => {
      device.asked = [kind, options];
      return new Session();
    },
  },
});
