"""The capture wizard: the plan, pass after pass, the survey."""
