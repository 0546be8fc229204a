"""Learning the aiming points: scenarios, rewards, data sets, surrogates, policies and the commands that train them.

Light modules first: ``policy_file`` and ``surrogate_file`` evaluate shipped models with NumPy and import no torch.
"""
