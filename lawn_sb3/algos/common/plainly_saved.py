"""Models whose files hold no code: settings as JSON, weights and optimisers as tensors, the same bytes each time.

Stable-Baselines3 pickles settings, and runs what a pickle says when it loads one. The files written here have the shape
of its own, so that ``set_parameters`` and what else reads its weights can read them; only ``load`` is another.
"""

import io
import json
import sys
import zipfile
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any, Self

import numpy as np
import torch as th
from gymnasium import spaces
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.type_aliases import GymEnv, TrainFreq, TrainFrequencyUnit
from stable_baselines3.common.utils import (
    ConstantSchedule,
    FloatSchedule,
    LinearSchedule,
    check_for_correct_spaces,
    get_device,
)
from stable_baselines3.common.vec_env import VecEnv

from lawn_sb3.algos.common.harmless import find_class, name_of
from lawn_sb3.algos.common.plain import Arrays, Kinds, from_plain, to_plain
from lawn_sb3.envs.observation import ObservationLayout
from lawn_sb3.scenario import Scenario

FORMAT = "lawn-sb3 1"
SETTINGS, ARRAYS = "data", "arrays.npz"
"""Members of the file; the first is called as in SB3's."""


def _made_by_name(kind: type) -> Callable[[Any], Any]:
    """What makes an object of its attributes, which its constructor takes by the same names."""
    return lambda of: kind(**of)


KINDS: Kinds = {
    "class": (type, name_of, find_class),
    "layout": (ObservationLayout, asdict, lambda of: ObservationLayout(**of)),
    "scenario": (Scenario, lambda one: one.model_dump(mode="json"), Scenario.model_validate),
    "box": (spaces.Box, lambda one: [one.low, one.high], lambda of: spaces.Box(*of, dtype=of[0].dtype)),
    "discrete": (spaces.Discrete, lambda one: int(one.n), spaces.Discrete),
    "train_freq": (
        TrainFreq,
        lambda one: [one.frequency, one.unit.value],
        lambda of: TrainFreq(of[0], TrainFrequencyUnit(of[1])),
    ),
    **{kind.__name__: (kind, vars, _made_by_name(kind)) for kind in (FloatSchedule, LinearSchedule, ConstantSchedule)},
}
"""What settings are made of."""
PASSING = {
    *("_last_obs", "_last_episode_starts", "_last_original_obs", "_last_lstm_states"),
    *("ep_info_buffer", "ep_success_buffer", "start_time", "_num_timesteps_at_start", "lr_schedule"),
    "exploration_schedule",
}
"""What belongs to a training that is under way, or is made of other settings."""


class PlainlySaved(BaseAlgorithm):
    """Mixin for an algorithm of SB3."""

    def save(self, path: str | Path | io.BufferedIOBase, exclude: Any = None, include: Any = None) -> None:
        """Save the model; equal models leave equal bytes.

        :param path: the file; ``.zip`` is added where its name has no ending
        :param exclude: more attributes to leave out
        :param include: attributes to keep that would be left out
        """
        left_out = ({*self._excluded_save_params(), *PASSING} | set(exclude or ())) - set(include or ())
        arrays: Arrays = {}
        settings: dict[str, Any] = {"format": [FORMAT, type(self).__name__]}
        for name, value in vars(self).items():
            if name not in left_out:
                try:
                    settings[name] = to_plain(value, arrays, KINDS)
                except TypeError:
                    settings[name] = {"missing": type(value).__name__}
        members = {SETTINGS: json.dumps(settings, indent=1).encode(), ARRAYS: _as_bytes(arrays)}
        for name, state in self.get_parameters().items():
            content = io.BytesIO()
            th.save(_interned(state), content)
            members[f"{name}.pth"] = content.getvalue()
        content = io.BytesIO()
        with zipfile.ZipFile(content, "w") as archive:
            for name, member in members.items():
                archive.writestr(zipfile.ZipInfo(name), member)  # of no time, unlike a name alone
        if isinstance(path, str | Path):
            path = Path(path) if Path(path).suffix else Path(path).with_suffix(".zip")
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content.getbuffer())
        else:
            path.write(content.getbuffer())

    @classmethod
    def load(
        cls,
        path: str | Path | io.BufferedIOBase,
        env: GymEnv | None = None,
        device: th.device | str = "auto",
        custom_objects: dict[str, Any] | None = None,
        print_system_info: bool = False,
        force_reset: bool = True,
        **kwargs: Any,
    ) -> Self:
        """Load a model; unlike SB3's, without running anything that the file holds.

        :param path: what :meth:`save` wrote
        :param env: an environment to go on in
        :param device: as in SB3
        :param custom_objects: settings in place of those in the file, such as a ``policy_class`` of one's own
        :param print_system_info: unused: the file does not say on which machine it was written
        :param force_reset: unused: the environment is always reset
        :param kwargs: attributes to change
        :return: the model
        :raises ValueError: if the file is no such model, or does not fit the environment
        """
        settings, arrays, parameters = _read(path, device)
        if settings["format"][1] != cls.__name__:
            raise ValueError(f"{_called(path)} is a {settings['format'][1]}, not a {cls.__name__}")
        given = custom_objects or {}
        values = {}
        for name, form in settings.items():
            if name == "format" or name in given:
                continue
            if isinstance(form, dict) and "missing" in form:
                raise ValueError(
                    f"{_called(path)} lacks its {name}: a {form['missing']} cannot be kept; give it in custom_objects"
                )
            try:
                values[name] = from_plain(form, arrays, KINDS)
            except (KeyError, TypeError, IndexError) as error:
                raise ValueError(f"{_called(path)} is damaged: {name} cannot be read") from error
        values |= given
        try:
            trained = values["policy_kwargs"].get("layout")
            if env is not None:
                env = cls._wrap_env(env, values["verbose"])
                values |= cls._fitted(values, env)
                check_for_correct_spaces(env, values["observation_space"], values["action_space"])
                values["n_envs"] = env.num_envs
            model = cls(policy=values["policy_class"], env=env, device=device, _init_setup_model=False)  # type: ignore[call-arg]
            vars(model).update(values | kwargs)
            model._setup_model()
        except (AssertionError, AttributeError, LookupError, NotImplementedError, TypeError) as error:
            what = f"{type(error).__name__}: {next(iter(str(error).splitlines()), '')}"
            raise ValueError(f"{_called(path)} makes no {cls.__name__} by its settings: {what}") from error
        try:
            model.set_parameters(parameters, exact_match=True, device=device)
        except RuntimeError as error:
            asked = None if env is None else values["policy_kwargs"].get("layout")
            raise ValueError(
                f"the model was trained for {trained} and its networks do not fit {asked or 'its settings'}: a critic "
                "that reads x has another input there"
            ) from error
        return model

    @classmethod
    def _fitted(cls, values: dict[str, Any], env: VecEnv) -> dict[str, Any]:
        """Settings of a saved model that are others in an environment."""
        return {}


def _interned(state: Any) -> Any:
    """The same state with each name there once: a file tells apart what is the same and what is only equal."""
    if isinstance(state, str):
        return sys.intern(state)
    if type(state) is dict:
        return {_interned(name): _interned(value) for name, value in state.items()}
    return state if not isinstance(state, list) else [_interned(value) for value in state]


def _as_bytes(arrays: Arrays) -> bytes:
    content = io.BytesIO()
    np.savez(content, allow_pickle=False, **arrays)
    return content.getvalue()


def _called(path: str | Path | io.BufferedIOBase) -> str:
    return repr(str(path)) if isinstance(path, str | Path) else "the model"


def _read(
    path: str | Path | io.BufferedIOBase, device: th.device | str
) -> tuple[dict[str, Any], dict[str, Any], dict[str, Any]]:
    """Settings in plain form, their arrays, and the parameters of a saved model."""
    if isinstance(path, str | Path) and not Path(path).exists() and not Path(path).suffix:
        path = Path(path).with_suffix(".zip")
    to = get_device(device)
    try:
        with zipfile.ZipFile(path) as archive:
            settings = json.loads(archive.read(SETTINGS))
            if not isinstance(settings.get("format"), list):
                raise ValueError(
                    "it was written by SB3 or by an earlier version, and its settings could only be read by running "
                    "what it holds; set_parameters reads its weights"
                )
            if len(settings["format"]) != 2 or settings["format"][0] != FORMAT:
                raise ValueError(f"its format is {settings['format']}, this version reads {FORMAT} alone")
            with np.load(io.BytesIO(archive.read(ARRAYS)), allow_pickle=False) as stored:
                arrays = {name: stored[name] for name in stored.files}
            parameters = {
                name.removesuffix(".pth"): th.load(io.BytesIO(archive.read(name)), map_location=to, weights_only=True)
                for name in archive.namelist()
                if name.endswith(".pth")
            }
    except FileNotFoundError:
        raise
    except Exception as error:  # whatever a damaged file brings about in those that read it
        raise ValueError(f"{_called(path)} cannot be loaded: {next(iter(str(error).splitlines()), error)}") from error
    return settings, arrays, parameters
