"""What MuJoCo's sensors say of people's contacts."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from halfphysics.mujoco.contact_data import PersonContacts

Array = NDArray[np.float64]


class SensorFeed:
    """Brings a MuJoCo world's accelerations, forces and sensors up to date after a timestep.

    `mj_step` has computed them without the people. Their forces are in `data.xfrc_applied` and
    `data.qacc` by now, so that MuJoCo itself computes `cfrc_ext`, `cfrc_int`, accelerometers, force
    and torque sensors anew. Touch sensors, which it makes from its own contacts, get the people's
    added by its own rule: the normal forces of the contacts of the site's body whose normals meet
    the site's shape.
    """

    def __init__(self, model: Any, data: Any) -> None:
        import mujoco

        self._model, self._data = model, data
        stage = np.asarray(model.sensor_needstage)
        self._any = bool((stage == int(mujoco.mjtStage.mjSTAGE_ACC)).any())
        kind = np.asarray(model.sensor_type)
        self._touch = np.flatnonzero(kind == int(mujoco.mjtSensor.mjSENS_TOUCH))
        #: People pushed in the timestep that was looked at last.
        self.pushed = False

    def update(self, pushed: bool, contacts: Callable[[], PersonContacts]) -> None:
        """After a timestep in which people had contacts, which are asked for where that matters."""
        import mujoco

        mujoco.mj_rnePostConstraint(self._model, self._data)
        self.pushed = pushed
        if not self._any or not self.pushed:
            return  # without contact they are right as they are
        mujoco.mj_sensorAcc(self._model, self._data)
        if mujoco.mjtDisableBit.mjDSBL_SENSOR & self._model.opt.disableflags:
            return
        if not len(self._touch):
            return
        rows = contacts()
        for sensor in self._touch:
            self._feel(int(sensor), rows)

    def _feel(self, sensor: int, contacts: PersonContacts) -> None:
        import mujoco

        model, data = self._model, self._data
        site = int(model.sensor_objid[sensor])
        body = int(model.site_bodyid[site])
        place, axes = data.site_xpos[site], data.site_xmat[site]
        size, kind = model.site_size[site], int(model.site_type[site])
        felt = 0.0
        for contact in contacts:
            of_first = contact.geom1 >= 0 and model.geom_bodyid[contact.geom1] == body
            of_second = contact.geom2 >= 0 and model.geom_bodyid[contact.geom2] == body
            if not (of_first or of_second) or contact.force[0] <= 0.0:
                continue
            ray = contact.frame[:3] if of_first else -contact.frame[:3]
            if mujoco.mju_rayGeom(place, axes, size, contact.pos, ray, kind) >= 0.0:
                felt += float(contact.force[0])
        most = float(model.sensor_cutoff[sensor])
        at = int(model.sensor_adr[sensor])
        total = float(data.sensordata[at]) + felt
        data.sensordata[at] = min(total, most) if most > 0.0 else total
