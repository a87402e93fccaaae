"use strict";
// Headsets (WebXR): the user stands at the eye's place; the trigger moves there where it points on the floor.

async function offerHeadset() {
  $("headset").hidden = !(await navigator.xr?.isSessionSupported("immersive-vr").catch(() => false));
}

function footing() {
  // Place and rotation of the house's origin relative to the eye's feet and direction: {place, turn}.
  const up = new THREE.Vector3(0, 1, 0), yaw = eye.yaw + Math.PI; // a headset looks along -z
  const turn = new THREE.Quaternion().setFromAxisAngle(up, -yaw);
  return { place: eye.feet.clone().negate().applyQuaternion(turn), turn };
}

async function enterHeadset() {
  let session;
  try {
    session = await navigator.xr.requestSession("immersive-vr", { requiredFeatures: ["local-floor"] });
  } catch (error) {
    $("message").textContent = `No headset: ${error.message}`;
    return;
  }
  $("message").textContent = "";
  setMode("walk");
  aim(canvas);
  for (const { mesh } of parts) mesh.visible = mesh.material.visible = true;
  for (const { mesh } of gathered) mesh.visible = false;
  Object.assign(camera, { near: 0.05, far: 4 * whole.radius });
  renderer.xr.enabled = true;
  await renderer.xr.setSession(session);
  const floor = renderer.xr.getReferenceSpace();
  const stand = () => {
    const { place, turn } = footing();
    renderer.xr.setReferenceSpace(floor.getOffsetReferenceSpace(new XRRigidTransform(place, turn)));
  };
  stand();
  session.addEventListener("select", ({ frame, inputSource }) => {
    const pose = frame.getPose(inputSource.targetRaySpace, renderer.xr.getReferenceSpace());
    if (!pose) return;
    const { position, orientation } = pose.transform, way = new THREE.Vector3(0, 0, -1).applyQuaternion(orientation);
    const hit = new THREE.Raycaster(new THREE.Vector3().copy(position), way).intersectObjects(parts.map((part) => part.mesh), false)[0];
    if (!hit || !GROUND.has(hit.object.part.extras.kind)) return;
    const head = renderer.xr.getCamera().position; // the user may have walked away from the start
    eye.feet.set(eye.feet.x + hit.point.x - head.x, hit.point.y, eye.feet.z + hit.point.z - head.z);
    stand();
  });
  session.addEventListener("end", () => {
    renderer.setAnimationLoop(null);
    renderer.xr.enabled = false;
    refresh();
  });
  renderer.setAnimationLoop(() => renderer.render(scene, camera));
}
