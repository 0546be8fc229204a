"""What a training writes down as it goes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from stable_baselines3.common.callbacks import BaseCallback  # noqa: TID253 - imported only where training is wanted

from tethernet_learning.policies import checkpoint, history
from tethernet_learning.run_progress import Progress


class Recorder(BaseCallback):
    """History and TensorBoard after every batch of episodes, a checkpoint between two updates."""

    def __init__(
        self, folder: Path, checkpoints: Path, lines: list[list[float]], progress: Progress, checkpoint_every: int
    ):
        """Args:
        folder: of the training.
        checkpoints: folder of the checkpoints.
        lines: the history so far, gone on with here.
        progress: told of every batch.
        checkpoint_every: episodes.
        """
        super().__init__()
        self._folder, self._checkpoints, self._lines = folder, checkpoints, lines
        self._progress, self._every = progress, checkpoint_every

    def _on_rollout_start(self) -> None:
        # Here the update with all episodes so far is behind, and no random number for the next one is drawn yet.
        if self.num_timesteps and self.num_timesteps % self._every == 0:
            history.write(self._folder / history.FILE, self._lines)
            checkpoint.save(self._checkpoints, self.model)

    def _on_step(self) -> bool:
        std = float(np.exp(self.model.policy.log_std.detach().numpy()).mean())
        line = history.line(self.num_timesteps, self.locals["infos"], std)
        self._lines.append(line)
        for name, value in zip(history.COLUMNS[1:], line[1:], strict=True):
            self.logger.record(f"batch/{name}", value)
        self.logger.dump(self.num_timesteps)
        more = f"reward {line[1]:.3f}, captured {100 * line[history.COLUMNS.index('captured')]:.0f} %"
        self._progress.tell(self.num_timesteps, more)
        return True
