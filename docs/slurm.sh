#!/bin/sh
# A sweep on a cluster: 4 nodes, one process a node, two hours; requeued until the set is complete.
#   sbatch docs/slurm.sh examples/random_sweep.toml /shared/random.h5
#SBATCH --job-name=tactel
#SBATCH --nodes=4
#SBATCH --ntasks-per-node=1
#SBATCH --cpus-per-task=32
#SBATCH --time=02:00:00
#SBATCH --signal=INT@120
#SBATCH --open-mode=append
#SBATCH --requeue
# Two minutes before the end Slurm sends SIGINT: tactel stops cleanly with exit code 130. (SIGTERM makes Slurm cancel the step: srun
# then waits for KillWait alone.)
export TACTEL_THREADS="$SLURM_CPUS_PER_TASK"
srun --mpi=pmix build/tactel generate "$1" --output "$2" --resume
code=$?
[ "$code" -eq 130 ] && scontrol requeue "$SLURM_JOB_ID"  # with the options that it was submitted with
exit "$code"
