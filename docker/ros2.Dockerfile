# The stock ROS 2 Jazzy command-line tools, with tethernet_msgs built for them: to look on while a mission flies.
#   docker build -f docker/ros2.Dockerfile -t tethernet-ros2 .
FROM ros:jazzy-ros-base

COPY ros2_ws/src/tethernet_msgs /tmp/src/tethernet_msgs
RUN . /opt/ros/jazzy/setup.sh \
    && colcon --log-base /tmp/log build --base-paths /tmp/src --build-base /tmp/build --merge-install --install-base /opt/tethernet \
    && rm -rf /tmp/src /tmp/build /tmp/log

# UDP only: the shared memory of a process outside this container, or of another user, cannot be read in here. The range
# LOCALHOST would bring shared memory back in; a mission that is flown with it finds these tools nevertheless.
ENV FASTDDS_BUILTIN_TRANSPORTS=UDPv4 \
    RMW_IMPLEMENTATION=rmw_fastrtps_cpp \
    ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET

ENTRYPOINT ["bash", "-c", ". /opt/tethernet/setup.bash && exec \"$@\"", "ros2"]
CMD ["bash"]
